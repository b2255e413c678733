#pragma once

#include <string>
#include <vector>

#include "relative/closure/joint_measure.h"
#include "relative/closure/speed_constraints.h"

/// Closure of a machine: its loops from what the cut joints permit, (R43) to (R46), its couplings, and its
/// nonholonomic constraints.
namespace concord::relative {

/// The rows that the tree's speeds obey: T^T of each cut joint, one after the other; then a row of each coupling; then
/// those that hold for velocities alone.
class Closure {
 public:
  using Cut = CutJoint;

  /// The kinematics must outlive this object.
  Closure(const Kinematics& kinematics, const PrescribedMask& prescribed);

  [[nodiscard]] int n_rows() const { return static_cast<int>(velocity_residual_.size()); }
  /// The rows that hold for positions too; they stand first.
  [[nodiscard]] int n_position_rows() const { return static_cast<int>(position_residual_.size()); }
  [[nodiscard]] const std::vector<Cut>& cuts() const { return cuts_; }
  [[nodiscard]] const std::vector<SpeedConstraint>& speed_constraints() const { return speed_constraints_.all(); }

  /// Measures the cut joints in the pose of the kinematics: writes their coordinates (guesses before) and speeds that
  /// are not prescribed into q and u. Then measures the couplings and the nonholonomic constraints (R43).
  void measure(VecX& q, VecX& u);

  /// Position closure T^T e [m, rad] and velocity closure T^T (v_rel - S u_prescribed) [m/s, rad/s]; of speed
  /// constraints free of units and 1/s; zero if closed. n_position_rows and n_rows numbers.
  [[nodiscard]] const VecX& position_residual() const { return position_residual_; }
  [[nodiscard]] const VecX& velocity_residual() const { return velocity_residual_; }
  /// The size of one unit of each row: the machine's length for a displacement, 1 for a rotation or a speed constraint.
  [[nodiscard]] const VecX& row_units() const { return row_units_; }

  /// Residual of the acceleration closure T^T (a_rel - Sdot u - S_prescribed udot_prescribed) and of the speed
  /// constraints, n_rows numbers, for the accelerations of the two joint points of every cut joint as
  /// `acceleration(joint, side)` gives them (a Vec6 in global axes) and accelerations of the tree and prescribed ones
  /// from udot (other entries are not read) (R44).
  template <class Acceleration>
  void compute_acceleration_residual(const Acceleration& acceleration, const VecX& udot, VecX& residual) const;

  /// Phi_u = T^T W B, and C^T of the speed constraints, n_rows x n_tree_u, dense (R46).
  [[nodiscard]] MatX Phi_u() const;

  /// What the largest entry in a vector of row numbers belongs to: "the loop of joint 'A'" or "coupling 'G'" or "the
  /// velocity of joint 'B'".
  [[nodiscard]] std::string worst_place(const VecX& rows) const;

 private:
  template <class Acceleration>
  [[nodiscard]] Vec6 free_acceleration(const Cut& cut, const Acceleration& acceleration) const;
  [[nodiscard]] Vec6 relative_acceleration(const Cut& cut, const Vec6& of_parent, const Vec6& of_child) const;
  void add_wrench_rows(JointIndex joint, const Mat6X& on_child, MatX& rows) const;

  const Kinematics* kinematics_;
  PrescribedMask prescribed_;
  std::vector<Cut> cuts_;
  SpeedConstraints speed_constraints_;
  VecX position_residual_;
  VecX velocity_residual_;
  VecX row_units_;
};

/// Rows w^T G_P for the columns w of `wrenches` (6 x n) at the point: n x (6 + m).
MatX rows_on_body(const JointPoint& point, const Mat6X& wrenches);

/// a_rel - Sdot u of a cut joint.
template <class Acceleration>
Vec6 Closure::free_acceleration(const Cut& cut, const Acceleration& acceleration) const {
  return relative_acceleration(cut, acceleration(cut.joint, Side::parent), acceleration(cut.joint, Side::child)) -
         cut.measure.motion_at().Sdot_u;
}

template <class Acceleration>
void Closure::compute_acceleration_residual(const Acceleration& acceleration, const VecX& udot, VecX& residual) const {
  for (const Cut& cut : cuts_) {
    Vec6 misfit = free_acceleration(cut, acceleration);
    const JointMotion& motion = cut.measure.motion_at();
    const Span& span = kinematics_->topology().joints[cut.joint];
    for (int c = 0; c < span.n_u; ++c) {
      if (prescribed_[span.first_u + c] != 0) misfit -= motion.S.col(c) * udot(span.first_u + c);
    }
    const int rows = cut.measure.n_rows();
    residual.segment(cut.first_row, rows).noalias() = cut.measure.T().leftCols(rows).transpose().lazyProduct(misfit);
  }
  if (!speed_constraints_.any()) return;
  speed_constraints_.compute_acceleration_residual(
      [&](CutIndex cut) { return free_acceleration(cuts_[cut], acceleration); }, udot, residual);
}

}  // namespace concord::relative
