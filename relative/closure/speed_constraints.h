#pragma once

#include <optional>
#include <vector>

#include "relative/closure/joint_measure.h"
#include "relative/closure/nonholonomic_constraint.h"

/// Constraints on joint speeds that close no loop: coupler constraints, one for each coupling of the model, and
/// nonholonomic constraints.
namespace concord::relative {

/// Size of a coupling's factors, in the units of the speeds: its row is divided by it, and so is free of units.
double size_of(const Coupling& coupling, const Kinematics& kinematics);

/// Sum of factor_k q_k minus the offset, for the coordinates of every joint (q of joint k from first_q of its span),
/// turns that are counted apart included.
double compute_position_residual(const Coupling& coupling, const Kinematics& kinematics, const VecX& q);

/// The largest |factor_k q_k|, without turns that are counted apart: what round-off of the residual is made of.
double size_of_terms(const Coupling& coupling, const Kinematics& kinematics, const VecX& q);
/// The largest of what whole turns that are counted apart add to them.
double size_of_turns(const Coupling& coupling, const Kinematics& kinematics);

/// Its rate, the sum of factor_k u_k.
double compute_velocity_residual(const Coupling& coupling, const Model& model, const Topology& topology, const VecX& u);

/// What one joint adds to the rows of a constraint: C^T u. A unit multiplier exerts coordinate forces -C: in the tree
/// on the joint's speeds; of a cut joint, which has none in the tree, with their coordinate wrench on both bodies.
struct ConstrainedJoint {
  JointIndex joint;
  JointPlace place;
  JointSquare C;   // n_u x rows
  JointColumns T;  // of a cut joint: coordinate wrenches of C (entries of prescribed speeds left out), 6 x rows, in the
                   // parent's joint frame: T^T v_rel = C^T u
  JointColumns T_global;

  [[nodiscard]] std::optional<CutIndex> cut() const { return cut_of(place); }
};

/// A coupler constraint (one row for q, u and udot) or the nonholonomic constraints of one joint (rows for u and udot).
struct SpeedConstraint {
  RowIndex first_row;
  int n_rows = 0;
  std::optional<int> coupling;  // its index in the model; none: nonholonomic
  double size = 1.0;            // of a coupling: see size_of
  std::vector<ConstrainedJoint> joints;
  JointVector bias;  // C^T udot + bias = 0

  [[nodiscard]] bool is_coupling() const { return coupling.has_value(); }
};

/// All speed constraints of a machine: first the couplings in the order of the model, then the joints whose types
/// permit fewer velocities than their motion has.
class SpeedConstraints {
 public:
  /// Rows are counted from `first_row`. The kinematics must outlive this object.
  SpeedConstraints(const Kinematics& kinematics, const PrescribedMask& prescribed, int first_row);

  [[nodiscard]] const std::vector<SpeedConstraint>& all() const { return constraints_; }
  [[nodiscard]] bool any() const { return !constraints_.empty(); }
  /// Rows that hold for positions too: those of couplings.
  [[nodiscard]] int n_position_rows() const { return n_position_rows_; }
  [[nodiscard]] int n_rows() const { return n_rows_; }

  /// Takes the pose of the kinematics and of the measured cut joints, q and u complete: rows, bias, and
  /// the residuals of position and velocity (free of units, 1/s). Throws SolverError where a joint's permitted speeds
  /// are dependent.
  void measure(const std::vector<CutJoint>& cuts, const VecX& q, const VecX& u, VecX& position_residual,
               VecX& velocity_residual);

  /// Adds C^T udot + bias to `residual`; a_rel - Sdot u of a cut joint as `free_acceleration(cut)` gives it, in the
  /// parent's joint frame, accelerations of the tree and prescribed ones from udot.
  template <class FreeAcceleration>
  void compute_acceleration_residual(const FreeAcceleration& free_acceleration, const VecX& udot, VecX& residual) const;

 private:
  void add_coupling(int number);
  void add_nonholonomic(JointIndex joint);
  ConstrainedJoint& part_of(SpeedConstraint& constraint, JointIndex joint);
  [[nodiscard]] const JointMotion& motion_of(const ConstrainedJoint& part, const std::vector<CutJoint>& cuts) const;
  void measure_cut(ConstrainedJoint& part, const CutJoint& cut, VecX::SegmentReturnType velocity_rows);
  [[nodiscard]] bool is_prescribed(const ConstrainedJoint& part, int c) const;

  const Kinematics* kinematics_;
  PrescribedMask prescribed_;
  std::vector<SpeedConstraint> constraints_;
  std::vector<NonholonomicConstraint> nonholonomic_;  // in the order of their rows
  int first_row_;
  int n_position_rows_ = 0;
  int n_rows_ = 0;
};

template <class FreeAcceleration>
void SpeedConstraints::compute_acceleration_residual(const FreeAcceleration& free_acceleration, const VecX& udot,
                                                     VecX& residual) const {
  for (const SpeedConstraint& constraint : constraints_) {
    auto rows = residual.segment(constraint.first_row, constraint.n_rows);
    rows = constraint.bias;
    for (const ConstrainedJoint& part : constraint.joints) {
      const Span& span = kinematics_->topology().joints[part.joint];
      const std::optional<CutIndex> cut = part.cut();
      for (int c = 0; c < span.n_u; ++c) {
        if (cut && !is_prescribed(part, c)) continue;
        rows += part.C.row(c).transpose() * udot(span.first_u + c);
      }
      if (cut) rows.noalias() += part.T.transpose().lazyProduct(free_acceleration(*cut));
    }
  }
}

}  // namespace concord::relative
