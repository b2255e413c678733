#pragma once

#include <vector>

#include "relative/closure/closure.h"
#include "relative/dynamics/articulated_inertias.h"
#include "relative/dynamics/reactions.h"
#include "relative/dynamics/tree_accelerations.h"

/// Iterative refinement of the accelerations, for trees whose articulated inertias are ill-conditioned.
namespace concord::relative {

/// Where a light flexible body carries a heavy one, its articulated inertia is nearly all that of the heavy one, seen
/// through its modes: the sum knows the modes' own inertia to a few digits only, with the square of the condition that
/// the motion itself has. What the accelerations leave of the equations of motion is summed up body by body, without
/// that square, and the tree is solved again for it. All memory is laid out at construction.
class AccelerationRefinement {
 public:
  /// What is referred to must outlive this object.
  AccelerationRefinement(const Kinematics& kinematics, const Closure& closure, const ArticulatedInertias& tree);

  /// Adds to the right sides of the tree what is left there, and solves again (R77). `reactions` were computed last
  /// from these accelerations, applied forces and multipliers.
  void refine(const ArticulatedInertias& tree, const Reactions& reactions, const AppliedForces& applied,
              const VecX& lambda, TreeAccelerations& accelerations);

 private:
  struct OfLink {
    Mat6X z_r;
    MatX z_a;
    MatX response;
  };

  void set_coordinate_forces(const AppliedForces& applied, const VecX& lambda);
  void set_residual(const ArticulatedInertias& tree, const Reactions& reactions, LinkIndex l);

  const Kinematics* kinematics_;
  const Closure* closure_;
  std::vector<OfLink> links_;
  VecX tau_;  // of springs, couplings and nonholonomic constraints on the speeds of the tree
};

}  // namespace concord::relative
