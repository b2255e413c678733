#pragma once

#include <array>
#include <vector>

#include "cartesian/joint_rows.h"
#include "cartesian/layout.h"
#include "cartesian/marker_kinematics.h"
#include "common/model.h"

/// Constraint equations of all joints: residuals, Jacobians over the body velocities, gamma.
namespace concord::cartesian {

/// The child's marker seen from the parent's: (d, R), and after that their rates.
void place_relative(const Marker& parent, const Marker& child, RelativeMotion& motion);
void move_relative(const Marker& parent, const Marker& child, RelativeMotion& motion);

/// One joint at the current state. Rows: first what the type forbids, then its drivers in the order of the model.
struct JointEquations {
  std::array<Marker, 2> markers;
  RelativeMotion motion;
  Vec3 gap = Vec3::Zero();          // r_Pi - r_Pj, global
  Vec3 linear_bias = Vec3::Zero();  // a_rel at Ydot = 0, parent's joint frame
  Vec3 angular_bias = Vec3::Zero();
  int first_row = 0;
  int n_forbids = 0;
  int n_rows = 0;
  std::array<Row, kMaxRows> rows;
  /// Column k: transposed Jacobian of row k over Y of the side's body, (6 + m) numbers: the generalized force of the
  /// row taken as a wrench at the side's point.
  std::array<Eigen::Matrix<double, Eigen::Dynamic, kMaxRows>, 2> Phi_Y_transposed;

  [[nodiscard]] const Marker& marker(Side side) const { return markers[index(side)]; }
};

class Constraints {
 public:
  Constraints(const Model& model, const Layout& layout);

  [[nodiscard]] int n_rows() const { return n_rows_; }
  [[nodiscard]] const JointEquations& joint(int k) const { return joints_[k]; }
  [[nodiscard]] int n_joints() const { return static_cast<int>(joints_.size()); }
  [[nodiscard]] const Mat3& rotation(int body) const { return rotations_[body]; }

  /// Points, frames, residuals and Jacobians at positions q: all of them, or of one body and of one joint after its
  /// bodies.
  void place(const Eigen::Ref<const VecX>& q);
  void place_body(int body, const Eigen::Ref<const VecX>& q);
  void place_joint(int k, const Eigen::Ref<const VecX>& q);
  /// Velocities and accelerations at Ydot = 0, for velocities Y; after place().
  void move(const Eigen::Ref<const VecX>& Y);
  void move_joint(int k, const Eigen::Ref<const VecX>& Y);

  /// Phi(q, t); turn angles of drivers modulo full turns.
  void write_residual(double t, Eigen::Ref<VecX> residual) const;
  /// Phi_Y Y + Phi_t; after move().
  void write_velocity_residual(double t, Eigen::Ref<VecX> residual) const;
  /// Phi_Y Y of one row of a joint; after move() or move_joint().
  [[nodiscard]] double row_rate(int k, int row) const;
  /// gamma of Phi_Y Ydot = gamma; after move().
  void write_gamma(double t, Eigen::Ref<VecX> gamma) const;

  /// Calls visit(k, side, body) for every side of every joint that sits on a moving body.
  template <class Visit>
  void each_moving_side(const Visit& visit) const {
    for (int k = 0; k < n_joints(); ++k) {
      for (const Side side : {Side::parent, Side::child}) {
        const int body = model_.joints[k].on(side).body;
        if (body != kGround) visit(k, side, body);
      }
    }
  }

  /// Transposed Jacobian over Y of the side's body of any row of a joint, for rows that are no constraints: (6 + m).
  void write_transposed(int joint, Side side, const Row& row, Eigen::Ref<VecX> column) const;

  /// Whether every joint is on the branch that its type means; otherwise the index of the first that is not.
  [[nodiscard]] int first_joint_off_branch() const;

 private:
  const Model& model_;
  const Layout& layout_;
  std::vector<JointEquations> joints_;
  std::vector<Mat3> rotations_;
  int n_rows_ = 0;
};

}  // namespace concord::cartesian
