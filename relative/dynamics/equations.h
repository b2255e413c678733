#pragma once

#include <optional>
#include <vector>

#include "common/results.h"
#include "relative/bodies/body_inertia.h"
#include "relative/bodies/velocity_transformation.h"
#include "relative/closure/closure.h"
#include "relative/dynamics/acceleration_refinement.h"
#include "relative/dynamics/articulated_inertias.h"
#include "relative/dynamics/loops.h"
#include "relative/dynamics/phases.h"
#include "relative/dynamics/reactions.h"
#include "relative/forces/applied_forces.h"

/// The equations of motion of one machine in relative coordinates.
namespace concord::relative {

/// Accelerations and joint wrenches for given time, coordinates and speeds. After construction nothing is allocated and
/// the cost is proportional to the number of bodies (plus that of eliminating the multipliers of loops that couple).
///
/// This is the entry for whoever wants evaluations and nothing else, such as a benchmark:
///   Equations equations(model);
///   const Evaluated& evaluated = equations.compute_accelerations(t, q, u);   // q, u: see topology.h for their order;
///   const JointReactions& found = equations.compute_reactions(evaluated);    // home() for a first q
class Equations {
 public:
  /// The model must outlive this object. Throws InputError if its loops cannot be opened.
  explicit Equations(const Model& model);
  Equations(const Equations&) = delete;
  Equations& operator=(const Equations&) = delete;

  [[nodiscard]] const Model& model() const { return *model_; }
  [[nodiscard]] const Kinematics& kinematics() const { return kinematics_; }
  [[nodiscard]] const Topology& topology() const { return kinematics_.topology(); }
  [[nodiscard]] const MachineSize& size() const { return kinematics_.size(); }
  [[nodiscard]] const Closure& closure() const { return closure_; }
  [[nodiscard]] const PrescribedMask& driven() const { return driven_; }

  /// Coordinates of the unmoved machine: all joints at home, no deformation.
  [[nodiscard]] VecX home() const;

  /// Counts whole turns apart from the coordinates that all other functions take and give: see Kinematics.
  void count_turns(const VecX& turns) {
    kinematics_.count_turns(turns);
    stands_ = false;
  }
  /// Counts all turns, those of turn springs too, as another copy of the same machine does.
  void count_turns_as(const Equations& other);

  /// Writes the driven entries of q and u: their laws at time t, without the turns that are counted apart here or by
  /// other kinematics of the same model.
  void prescribe(double t, VecX& q, VecX& u) const { prescribe(t, kinematics_, q, u); }
  void prescribe(double t, const Kinematics& counted, VecX& q, VecX& u) const;

  /// Poses and velocities alone, for whoever measures cut joints with a closure of his own: all that was computed
  /// before is that of another pose.
  void place(double t, const VecX& q, const VecX& u);

  /// Poses, velocities and closure misfits at time t, q, u (n_q and n_u numbers). Driven entries are replaced by their
  /// laws, those of cut joints by measurement (q gives the guess).
  const Motion& move(double t, const VecX& q, const VecX& u);
  /// Whether, from now on, that is left out where the machine stands so already: a step of a run asks again and again.
  void keep_pose(bool keeps) { keeps_pose_ = keeps; }

  /// move, and udot from (R32). Throws SolverError if a link has no inertia, the pose is singular or a force
  /// element is not defined in it.
  const Evaluated& compute_accelerations(double t, const VecX& q, const VecX& u);

  /// The same, refined wherever a link is flexible: for single states, whose every digit counts.
  const Evaluated& compute_refined_accelerations(double t, const VecX& q, const VecX& u);

  /// move, and applied forces: what the tires of a state do, without its accelerations.
  const AppliedForces& update_forces(double t, const VecX& q, const VecX& u);

  /// A motion of one joint of the opened tree that has no inertia in this pose. Throws SolverError if modes are to
  /// blame.
  [[nodiscard]] std::optional<MotionWithoutInertia> find_motion_without_inertia(double t, const VecX& q, const VecX& u);

  /// Wrenches of all joints for accelerations.
  const JointReactions& compute_reactions(const Evaluated& evaluated);
  /// Wrenches that multipliers alone hold in balance, without load.
  const JointReactions& compute_self_stress(const Motion& motion, const VecX& lambda);

  /// qdot = N(q) u for all coordinates, cut joints' and modal ones included.
  void compute_qdot(const Motion& motion, VecX& qdot) const;

  /// Power of drivers, joint springs and force elements minus modal dissipation adot^T D adot [W] (R61).
  [[nodiscard]] double power(const Evaluated& evaluated);
  [[nodiscard]] bool has_applied_forces() const { return applied_.any(); }
  [[nodiscard]] bool has_drivers() const { return !drivers_.empty(); }

  /// The pose in which the machine stands.
  [[nodiscard]] const Motion& motion() const { return motion_; }
  [[nodiscard]] const AppliedForces& applied_forces() const { return applied_; }
  AppliedForces& applied_forces() { return applied_; }
  [[nodiscard]] const Loops& loops() const { return loops_; }
  Loops& loops() { return loops_; }

 private:
  /// One driver and the indices of its coordinate and speed.
  struct Prescription {
    const TimeFunction* law;
    JointIndex joint;
    int q, u;
  };

  void update_inertias();
  /// Accelerations, refined where the least pivot of a flexible link is below `refined_below`.
  const Evaluated& compute(double t, const VecX& q, const VecX& u, double refined_below);
  void refine_accelerations();
  void require_current(const Evaluated& evaluated) const;

  const Model* model_;
  Kinematics kinematics_;
  PrescribedMask driven_;
  Closure closure_;
  AppliedForces applied_;
  ArticulatedInertias tree_;
  TreeAccelerations accelerations_;
  Loops loops_;
  Reactions reactions_;
  AccelerationRefinement refinement_;
  std::vector<Prescription> drivers_;
  std::vector<BodyInertia> inertias_;  // by link
  VecX prescribed_udot_;               // zero where no driver acts
  Motion motion_;
  bool stands_ = false;  // in that motion
  bool keeps_pose_ = false;
  Evaluated evaluated_;
};

}  // namespace concord::relative
