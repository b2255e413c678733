#pragma once

#include <optional>
#include <vector>

#include "common/results.h"
#include "relative/bodies/body_inertia.h"
#include "relative/closure/closure.h"
#include "relative/dynamics/tree_accelerations.h"
#include "relative/forces/applied_forces.h"

/// Joint wrenches by the backward pass of Steps 1 to 5, (R54) to (R60).
namespace concord::relative {

/// What the joints of a machine transmit in one pose.
struct JointReactions {
  std::vector<JointWrenches> joints;
  /// Force f of each coupling, and the coordinate forces factor_k f of all couplings on every speed (n_u numbers).
  std::vector<double> couplings;
  VecX coupling_tau;
};

/// The wrenches of all joints in the pose of the kinematics. All memory is laid out at construction.
class Reactions {
 public:
  /// Both must outlive this object.
  Reactions(const Kinematics& kinematics, const Closure& closure);

  /// Wrenches for accelerations, applied forces, inertias (by link) and multipliers; of the shares those of drivers.
  const JointReactions& compute(const std::vector<BodyInertia>& inertias, const TreeAccelerations& accelerations,
                                const AppliedForces& applied, const VecX& lambda);

  /// The same of drivers' shares alone, for their power: of no other joint anything is written.
  const JointReactions& compute_driver_forces(const std::vector<BodyInertia>& inertias,
                                              const TreeAccelerations& accelerations, const AppliedForces& applied,
                                              const VecX& lambda);

  /// Shares out what springs, dampers and motors of joints exert, of the last compute() with these forces.
  void share_out_springs(const AppliedForces& applied);

  /// What the accelerations of the last compute() leave on a link, outboard links among it: six rigid rows about the
  /// body's reference point, all that its joint passes, and the modal rows, which vanish but for round-off (R58).
  [[nodiscard]] const Vec6& rho(LinkIndex l) const { return loads_[l].rho; }
  [[nodiscard]] const VecX& rho_a(LinkIndex l) const { return loads_[l].rho_a; }

  /// Wrenches that hold each other in balance without load, M, S, U, Q = 0: those of the multipliers alone.
  const JointReactions& compute_self_stress(const VecX& lambda);

 private:
  /// rho of one link: six rigid rows about the body's reference point and the modal rows.
  struct Load {
    Vec6 rho = Vec6::Zero();
    VecX rho_a;
    std::optional<LinkIndex> reference;  // the link of the reference body; none at ground
    bool acts_at_one_point = false;      // the joint, whose points coincide in every pose
  };
  /// A joint on whose coordinates drivers, springs or couplings act, and the columns of the driven ones.
  struct ForcedJoint {
    JointIndex joint;
    std::optional<CutIndex> cut;      // none in the tree
    std::optional<int> nonholonomic;  // its index in Closure::speed_constraints
    std::vector<int> driven;
  };

  void balance(const std::vector<BodyInertia>& inertias, const TreeAccelerations& accelerations,
               const AppliedForces& applied, const VecX& lambda);
  void load_inertia(const std::vector<BodyInertia>& inertias, const TreeAccelerations& accelerations);
  void subtract_applied(const AppliedForces& applied);
  void set_spring_forces(const AppliedForces& applied);
  void set_coupling_forces(const VecX& lambda);
  void add_coupling_forces();
  void clear_loads();
  void apply_cut_wrenches(const VecX& lambda);
  void apply_speed_constraint_wrenches(const VecX& lambda);
  Vec6 exert_at_cut(JointIndex joint, const Vec6& on_child);
  void add_spring_wrenches_of_cuts(const AppliedForces& applied);
  void backward_pass();
  void subtract_from(BodyIndex body, const JointPoint& point, const Vec6& wrench);
  [[gnu::always_inline]] static inline void subtract_from(Load& load, const JointPoint& point, const Vec6& wrench);
  void add_to_total(JointIndex joint, const Vec6& on_child, const Vec6& on_parent);
  void report(JointIndex joint, const Vec6& on_child, const Vec6& on_parent);
  [[nodiscard]] const JointMotion& motion_of(const ForcedJoint& forced) const;
  void set_driver_forces(const ForcedJoint& forced, const VecX& lambda);
  void split_off_coordinate_wrenches(const VecX& lambda);

  const Kinematics* kinematics_;
  const Closure* closure_;
  std::vector<Load> loads_;
  std::vector<ForcedJoint> forced_joints_;
  std::vector<char> is_driven_;  // by joint
  bool reports_all_ = true;      // not those of driven joints alone
  VecX tau_of_springs_;
  JointReactions found_;
};

}  // namespace concord::relative
