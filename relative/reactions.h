#pragma once

#include <optional>
#include <vector>

#include "common/results.h"
#include "relative/applied_forces.h"
#include "relative/articulated_bodies.h"
#include "relative/body_inertia.h"
#include "relative/closure.h"

/// Joint wrenches by the backward pass of Steps 1 to 5, (R54) to (R60).
namespace concord::relative {

/// The wrenches of all joints from accelerations and cut-joint multipliers. All memory is laid out at construction.
class Reactions {
 public:
  /// All four must outlive this object.
  Reactions(const Kinematics& kinematics, const Closure& closure, const ArticulatedBodies& articulated_bodies,
            const AppliedForces& applied);

  /// Wrenches for the accelerations that the articulated bodies hold, the applied forces, the inertias (by link) and
  /// the multipliers.
  void compute(const std::vector<BodyInertia>& inertias, const VecX& lambda);

  /// Wrenches that hold each other in balance without load, M, S, U, Q = 0: those of the multipliers alone.
  void compute_self_stress(const VecX& lambda);

  [[nodiscard]] const std::vector<JointWrenches>& joints() const { return joints_; }
  /// Force f of each coupling, and the coordinate forces factor_k f of all couplings on every speed (n_u numbers).
  [[nodiscard]] const std::vector<double>& couplings() const { return couplings_; }
  [[nodiscard]] const VecX& coupling_tau() const { return coupling_tau_; }

  /// The modal rows of Step 5 that must vanish, rho_a - G_a^T [F; T], of the worst body, relative to the largest term
  /// of its rows; and that body's index (ground if no body is flexible).
  [[nodiscard]] double modal_residual() const { return modal_residual_; }
  [[nodiscard]] int worst_modal_body() const { return worst_modal_body_; }

 private:
  /// rho of one link: six rigid rows about the body's origin and the modal rows.
  struct Load {
    Vec6 rho = Vec6::Zero();
    VecX rho_a;
    double largest_modal_term = 0.0;
  };
  /// A joint on whose coordinates drivers, springs or couplings act, and the columns of the driven ones.
  struct ForcedJoint {
    int joint = 0;
    std::optional<int> cut;           // its index in Closure::cuts; none in the tree
    std::optional<int> nonholonomic;  // its index in Closure::speed_constraints
    std::vector<int> driven;
  };

  void load_inertia(const std::vector<BodyInertia>& inertias);
  void subtract_applied();
  void set_spring_forces();
  void set_coupling_forces(const VecX& lambda);
  void add_coupling_forces();
  void clear_loads();
  void apply_cut_wrenches(const VecX& lambda);
  void apply_speed_constraint_wrenches(const VecX& lambda);
  Vec6 exert_at_cut(int joint, const Vec6& on_child);
  void add_spring_wrenches_of_cuts();
  void backward_pass();
  void subtract_from(int body, const JointPoint& point, const Vec6& wrench);
  void audit_modal_rows(int l, const Vec6& wrench);
  void add_to_total(int joint, const Vec6& on_child, const Vec6& on_parent);
  void report(int joint, const Vec6& on_child, const Vec6& on_parent);
  void split_off_coordinate_wrenches(const VecX& lambda);

  const Kinematics* kinematics_;
  const Closure* closure_;
  const ArticulatedBodies* articulated_bodies_;
  const AppliedForces* applied_;
  std::vector<Load> loads_;
  std::vector<ForcedJoint> forced_joints_;
  std::vector<JointWrenches> joints_;
  std::vector<double> couplings_;
  VecX coupling_tau_;
  double modal_residual_ = 0.0;
  int worst_modal_body_ = kGround;
};

/// Throws SolverError if the free modal equations are out of balance by more than round-off explains (R58).
void require_modal_balance(const Reactions& reactions, const Model& model, double t);

}  // namespace concord::relative
