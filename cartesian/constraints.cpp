#include "cartesian/constraints.h"

#include <cmath>

#include "cartesian/euler_parameters.h"

namespace concord::cartesian {

namespace {

constexpr double kFullTurn = 2.0 * EIGEN_PI;

/// A row's gradient over (d, rho) as force and torque at the side's point: on the child as it is, on the parent
/// opposite and moved from P_i to P_j.
template <class Column>
void write_row(const JointEquations& joint, Side side, const Row& row, Column&& column) {
  const Mat3& A_joint = joint.marker(Side::parent).A_joint;
  const Vec3 force = A_joint * row.over_d;
  const Vec3 torque = A_joint * row.over_rho;
  if (side == Side::child) {
    write_generalized_force(joint.marker(side), force, torque, column);
  } else {
    write_generalized_force(joint.marker(side), -force, -(torque + joint.gap.cross(force)), column);
  }
}

void evaluate_rows(const Joint& stated, JointEquations& joint) {
  evaluate_forbids(*stated.type, joint.motion, joint.rows.data());
  for (std::size_t j = 0; j < stated.drivers.size(); ++j) {
    joint.rows[joint.n_forbids + j] =
        evaluate_read(*read_of(*stated.type, stated.drivers[j].word), stated.drivers[j].component, joint.motion);
  }
}

}  // namespace

void place_relative(const Marker& parent, const Marker& child, RelativeMotion& motion) {
  motion.d = parent.A_joint.transpose() * (child.point - parent.point);
  motion.R = parent.A_joint.transpose() * child.A_joint;
}

void move_relative(const Marker& parent, const Marker& child, RelativeMotion& motion) {
  const Vec3 carried = parent.angular_velocity.cross(child.point - parent.point);
  motion.ddot = parent.A_joint.transpose() * (child.velocity - parent.velocity - carried);
  motion.omega = parent.A_joint.transpose() * (child.angular_velocity - parent.angular_velocity);
}

Constraints::Constraints(const Model& model, const Layout& layout)
    : model_(model), layout_(layout), rotations_(model.bodies.size(), Mat3::Identity()) {
  for (const Joint& joint : model.joints) {
    JointEquations equations;
    equations.first_row = n_rows_;
    equations.n_forbids = joint.type->rows();
    equations.n_rows = equations.n_forbids + static_cast<int>(joint.drivers.size());
    n_rows_ += equations.n_rows;
    for (const Side side : {Side::parent, Side::child}) {
      const Attachment& attachment = joint.on(side);
      equations.markers[index(side)] = make_marker(attachment);
      if (attachment.body != kGround) {
        equations.Phi_Y_transposed[index(side)].setZero(layout.size_Y(attachment.body), kMaxRows);
      }
      const VecX none;
      concord::cartesian::place(attachment, Vec3::Zero(), Mat3::Identity(), none.head(0),
                                equations.markers[index(side)]);
    }
    joints_.push_back(std::move(equations));
  }
}

void Constraints::place(const Eigen::Ref<const VecX>& q) {
  for (int i = 1; i < layout_.n_bodies(); ++i) place_body(i, q);
  for (int k = 0; k < n_joints(); ++k) place_joint(k, q);
}

void Constraints::place_body(int body, const Eigen::Ref<const VecX>& q) {
  rotations_[body] = rotation_of(layout_.p(q, body));
}

void Constraints::place_joint(int k, const Eigen::Ref<const VecX>& q) {
  JointEquations& joint = joints_[k];
  const Joint& stated = model_.joints[k];
  for (const Side side : {Side::parent, Side::child}) {
    const Attachment& attachment = stated.on(side);
    const int body = attachment.body;
    if (body == kGround) continue;  // placed once, at construction
    concord::cartesian::place(attachment, layout_.r(q, body), rotations_[body], layout_.a(q, body),
                              joint.markers[index(side)]);
  }
  const Marker& on_parent = joint.marker(Side::parent);
  const Marker& on_child = joint.marker(Side::child);
  joint.gap = on_child.point - on_parent.point;
  place_relative(on_parent, on_child, joint.motion);
  joint.motion.ddot.setZero();
  joint.motion.omega.setZero();
  evaluate_rows(stated, joint);
  for (const Side side : {Side::parent, Side::child}) {
    if (stated.on(side).body == kGround) continue;
    auto& Phi_Y_transposed = joint.Phi_Y_transposed[index(side)];
    for (int row = 0; row < joint.n_rows; ++row) write_row(joint, side, joint.rows[row], Phi_Y_transposed.col(row));
  }
}

void Constraints::move(const Eigen::Ref<const VecX>& Y) {
  for (int k = 0; k < n_joints(); ++k) move_joint(k, Y);
}

void Constraints::move_joint(int k, const Eigen::Ref<const VecX>& Y) {
  JointEquations& joint = joints_[k];
  const Joint& stated = model_.joints[k];
  for (const Side side : {Side::parent, Side::child}) {
    const Attachment& attachment = stated.on(side);
    const int body = attachment.body;
    if (body == kGround) continue;
    concord::cartesian::move(attachment, rotations_[body], layout_.v(Y, body), layout_.omega(Y, body),
                             layout_.adot(Y, body), joint.markers[index(side)]);
  }
  const Marker& parent = joint.marker(Side::parent);
  const Marker& child = joint.marker(Side::child);
  const Mat3& A_joint = parent.A_joint;
  const Vec3& omega_j = parent.angular_velocity;
  const Vec3 closing = child.velocity - parent.velocity;
  const Vec3 carried = omega_j.cross(joint.gap);
  move_relative(parent, child, joint.motion);
  joint.linear_bias = A_joint.transpose() *
                      (child.velocity_bias - parent.velocity_bias - parent.angular_velocity_bias.cross(joint.gap) -
                       2.0 * omega_j.cross(closing) + omega_j.cross(carried));
  joint.angular_bias = A_joint.transpose() * (child.angular_velocity_bias - parent.angular_velocity_bias -
                                              omega_j.cross(child.angular_velocity));
  evaluate_rows(stated, joint);
}

void Constraints::write_residual(double t, Eigen::Ref<VecX> residual) const {
  for (int k = 0; k < n_joints(); ++k) {
    const JointEquations& joint = joints_[k];
    const Joint& stated = model_.joints[k];
    for (int row = 0; row < joint.n_forbids; ++row) residual(joint.first_row + row) = joint.rows[row].value;
    for (int row = joint.n_forbids; row < joint.n_rows; ++row) {
      const Driver& driver = stated.drivers[row - joint.n_forbids];
      const double error = joint.rows[row].value - evaluate(driver.law, t).f;
      residual(joint.first_row + row) =
          reads_turn(*read_of(*stated.type, driver.word), driver.component) ? std::remainder(error, kFullTurn) : error;
    }
  }
}

void Constraints::write_velocity_residual(double t, Eigen::Ref<VecX> residual) const {
  for (int k = 0; k < n_joints(); ++k) {
    const JointEquations& joint = joints_[k];
    const Joint& stated = model_.joints[k];
    for (int row = 0; row < joint.n_rows; ++row) {
      double rate = row_rate(k, row);
      if (row >= joint.n_forbids) rate -= evaluate(stated.drivers[row - joint.n_forbids].law, t).fdot;
      residual(joint.first_row + row) = rate;
    }
  }
}

double Constraints::row_rate(int k, int row) const {
  const JointEquations& joint = joints_[k];
  return rate_of(joint.rows[row], joint.motion);
}

void Constraints::write_gamma(double t, Eigen::Ref<VecX> gamma) const {
  for (int k = 0; k < n_joints(); ++k) {
    const JointEquations& joint = joints_[k];
    const Joint& stated = model_.joints[k];
    for (int row = 0; row < joint.n_rows; ++row) {
      const Row& gradient = joint.rows[row];
      double rest = gradient.over_d.dot(joint.linear_bias) + gradient.over_rho.dot(joint.angular_bias) + gradient.bias;
      if (row >= joint.n_forbids) rest -= evaluate(stated.drivers[row - joint.n_forbids].law, t).fddot;
      gamma(joint.first_row + row) = -rest;
    }
  }
}

void Constraints::write_transposed(int joint, Side side, const Row& row, Eigen::Ref<VecX> column) const {
  write_row(joints_[joint], side, row, column);
}

int Constraints::first_joint_off_branch() const {
  for (int k = 0; k < n_joints(); ++k) {
    if (!on_branch(*model_.joints[k].type, joints_[k].motion)) return k;
  }
  return -1;
}

}  // namespace concord::cartesian
