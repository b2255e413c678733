#pragma once

#include <vector>

#include "common/results.h"
#include "relative/bodies/motion.h"
#include "relative/dynamics/loops.h"
#include "relative/dynamics/tree_accelerations.h"
#include "relative/forces/applied_forces.h"

/// What the phases of an evaluation hand on: each result can be had from the phase before it alone, and is asked for by
/// the one after it.
///
///   Equations::move                  -> Motion           the pose, all velocities, the measured closure
///   Equations::compute_accelerations -> Evaluated        articulated inertias, loops, accelerations
///   Equations::compute_reactions     -> JointReactions   wrenches of all joints
///
/// They live in the equations, and say what holds until the machine is moved again. Equations::compute_reactions and
/// power refuse with std::logic_error what comes from a pose that the machine has left.
namespace concord::relative {

/// A machine in a pose, accelerated as its equations of motion say.
class Evaluated {
 public:
  [[nodiscard]] const TreeAccelerations& accelerations() const { return *accelerations_; }
  /// Accelerations of the tree's speeds (n_u numbers, of cut joints only the driven ones).
  [[nodiscard]] const VecX& udot() const { return accelerations_->udot(); }
  [[nodiscard]] const LoopSolution& loops() const { return *loops_; }
  [[nodiscard]] const AppliedForces& applied_forces() const { return *applied_; }
  /// By link.
  [[nodiscard]] const std::vector<BodyInertia>& inertias() const { return *inertias_; }
  /// Accelerations of a body's origin, angular and modal ones.
  [[nodiscard]] BodyAcceleration acceleration(BodyIndex body) const {
    const Vec6 Vdot = kinematics_->acceleration_of_origin(body, accelerations_->of_body(body));
    const VecX* addot = accelerations_->of_modes(body);
    return {Vdot.head<3>(), Vdot.tail<3>(), addot == nullptr ? VecX() : *addot};
  }

 private:
  friend class Equations;
  Evaluated(const Kinematics& kinematics, const TreeAccelerations& accelerations, const LoopSolution& loops,
            const AppliedForces& applied, const std::vector<BodyInertia>& inertias)
      : kinematics_(&kinematics),
        accelerations_(&accelerations),
        loops_(&loops),
        applied_(&applied),
        inertias_(&inertias) {}

  const Kinematics* kinematics_;
  const TreeAccelerations* accelerations_;
  const LoopSolution* loops_;
  const AppliedForces* applied_;
  const std::vector<BodyInertia>* inertias_;
  long motion_ = -1;  // the number of its motion
};

}  // namespace concord::relative
