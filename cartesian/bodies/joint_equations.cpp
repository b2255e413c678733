#include "cartesian/bodies/joint_equations.h"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "cartesian/bodies/small_products.h"

namespace concord::cartesian {

namespace {

/// A row's gradient over (d, rho) as force and torque on the child at P_i, global axes.
struct RowWrench {
  Vec3 force;
  Vec3 torque;

  RowWrench(const JointEquations& joint, const ConstraintRow& row) {
    const Mat3& A_joint = joint.marker(Side::parent).A_joint;
    force = times(A_joint, row.over_d);
    torque = times(A_joint, row.over_rho);
  }
};

/// On the child as it is, on the parent opposite and moved from P_i to P_j (C26).
template <class Column>
void write_row(const JointEquations& joint, Side side, const RowWrench& wrench, Column&& column) {
  if (side == Side::child) {
    write_generalized_force(joint.marker(side), wrench.force, wrench.torque, column);
  } else {
    write_generalized_force(joint.marker(side), -wrench.force, -(wrench.torque + cross(joint.gap, wrench.force)),
                            column);
  }
}

void evaluate_rows(const Joint& stated, JointEquations& joint) {
  const int n_forbids = evaluate_forbids(*stated.type, joint.motion, joint.rows.data());
  evaluate_forbidden_speeds(*stated.type, joint.motion, joint.rows.data() + n_forbids);
  for (std::size_t j = 0; j < stated.drivers.size(); ++j) {
    joint.rows[joint.first_driver + j] =
        evaluate_read(*read_of(*stated.type, stated.drivers[j].word), stated.drivers[j].component, joint.motion);
  }
  for (std::size_t j = 0; j < joint.coupled.size(); ++j) {
    joint.rows[joint.n_rows + j] = evaluate_read(*joint.coupled[j].read, joint.coupled[j].component, joint.motion);
  }
}

/// Index of an arm's elevation among the coordinates, if the type has one.
std::optional<int> place_of_elevation(const joints::JointType& type) {
  std::optional<int> found;
  int place = 0;
  for (const joints::Read& read : type.reads) {
    if (is_elevation(read)) found = place;
    place += n_q(read);
  }
  return found;
}

}  // namespace

void place_relative(const Marker& parent, const Marker& child, RelativeMotion& motion) {
  motion.d = transpose_times(parent.A_joint, Vec3(child.point - parent.point));
  transpose_times(parent.A_joint, child.A_joint, motion.R);
}

void move_relative(const Marker& parent, const Marker& child, RelativeMotion& motion) {
  const Vec3 carried = cross(parent.angular_velocity, Vec3(child.point - parent.point));
  motion.ddot = transpose_times(parent.A_joint, Vec3(child.velocity - parent.velocity - carried));
  motion.omega = transpose_times(parent.A_joint, Vec3(child.angular_velocity - parent.angular_velocity));
}

JointEquations make_joint_equations(const Joint& stated, const Layout& layout, RowIndex first_row,
                                    std::vector<CoupledCoordinate> coupled) {
  JointEquations joint;
  joint.first_row = first_row;
  joint.n_forbids = stated.type->rows();
  joint.first_driver = joint.n_forbids + stated.type->nonholonomic_rows();
  joint.n_rows = joint.first_driver + static_cast<int>(stated.drivers.size());
  joint.n_u = stated.type->n_u();
  for (const Driver& driver : stated.drivers) {
    joint.driver_turns.push_back(reads_turn(*read_of(*stated.type, driver.word), driver.component));
  }
  joint.elevation = place_of_elevation(*stated.type);
  joint.coupled = std::move(coupled);
  joint.rows.resize(joint.n_rows + joint.coupled.size());
  for (const Side side : {Side::parent, Side::child}) {
    const Attachment& attachment = stated.on(side);
    Marker& marker = joint.markers[index(side)];
    marker = make_marker(attachment);
    const VecX none;
    place(attachment, Vec3::Zero(), Mat3::Identity(), none.head(0), marker);
    if (is_ground(body_of(attachment))) continue;
    joint.Phi_Y_transposed[index(side)].setZero(layout.size_Y(body_of(attachment)),
                                                static_cast<Eigen::Index>(joint.rows.size()));
  }
  return joint;
}

namespace {

void place_markers(const Joint& stated, const Layout& layout, const ByBody<Mat3>& rotations,
                   const Eigen::Ref<const VecX>& q, JointEquations& joint) {
  for (const Side side : {Side::parent, Side::child}) {
    const Attachment& attachment = stated.on(side);
    const BodyIndex body = body_of(attachment);
    if (is_ground(body)) continue;  // placed once, at construction
    try {
      place(attachment, layout.r(q, body), rotations[body], layout.a(q, body), joint.markers[index(side)]);
    } catch (const LargeRotation& turned) {
      throw LargeRotation(fmt::format("joint '{}'", stated.name), turned.angle);
    }
  }
  const Marker& on_parent = joint.marker(Side::parent);
  const Marker& on_child = joint.marker(Side::child);
  joint.gap = on_child.point - on_parent.point;
  place_relative(on_parent, on_child, joint.motion);
}

void move_markers(const Joint& stated, const Layout& layout, const ByBody<Mat3>& rotations,
                  const Eigen::Ref<const VecX>& Y, JointEquations& joint) {  // (C14)
  for (const Side side : {Side::parent, Side::child}) {
    const Attachment& attachment = stated.on(side);
    const BodyIndex body = body_of(attachment);
    if (is_ground(body)) continue;
    move(attachment, rotations[body], layout.v(Y, body), layout.omega(Y, body), layout.adot(Y, body),
         joint.markers[index(side)]);
  }
  const Marker& parent = joint.marker(Side::parent);
  const Marker& child = joint.marker(Side::child);
  const Mat3& A_joint = parent.A_joint;
  const Vec3& omega_j = parent.angular_velocity;
  const Vec3 closing = child.velocity - parent.velocity;
  const Vec3 carried = cross(omega_j, joint.gap);
  move_relative(parent, child, joint.motion);
  const Vec3 linear = child.velocity_bias - parent.velocity_bias - cross(parent.angular_velocity_bias, joint.gap) -
                      2.0 * cross(omega_j, closing) + cross(omega_j, carried);
  const Vec3 angular =
      child.angular_velocity_bias - parent.angular_velocity_bias - cross(omega_j, child.angular_velocity);
  joint.linear_bias = transpose_times(A_joint, linear);
  joint.angular_bias = transpose_times(A_joint, angular);
}

void write_rows(const Joint& stated, JointEquations& joint) {
  const std::array<bool, 2> moves = {!is_ground(body_of(stated.sides[0])), !is_ground(body_of(stated.sides[1]))};
  for (std::size_t row = 0; row < joint.rows.size(); ++row) {
    const RowWrench wrench(joint, joint.rows[row]);
    for (const Side side : {Side::parent, Side::child}) {
      if (!moves[index(side)]) continue;
      write_row(joint, side, wrench, joint.Phi_Y_transposed[index(side)].col(static_cast<Eigen::Index>(row)));
    }
  }
}

}  // namespace

void place_joint(const Joint& stated, const Layout& layout, const ByBody<Mat3>& rotations,
                 const Eigen::Ref<const VecX>& q, JointEquations& joint) {
  place_markers(stated, layout, rotations, q, joint);
  joint.motion.ddot.setZero();
  joint.motion.omega.setZero();
  evaluate_rows(stated, joint);
  write_rows(stated, joint);
}

void move_joint(const Joint& stated, const Layout& layout, const ByBody<Mat3>& rotations,
                const Eigen::Ref<const VecX>& Y, JointEquations& joint) {
  move_markers(stated, layout, rotations, Y, joint);
  evaluate_rows(stated, joint);
}

void place_and_move_joint(const Joint& stated, const Layout& layout, const ByBody<Mat3>& rotations,
                          const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y, JointEquations& joint) {
  place_markers(stated, layout, rotations, q, joint);
  move_markers(stated, layout, rotations, Y, joint);
  evaluate_rows(stated, joint);
  write_rows(stated, joint);
}

void write_transposed(const JointEquations& joint, Side side, const ConstraintRow& row, Eigen::Ref<VecX> column) {
  write_row(joint, side, RowWrench(joint, row), column);
}

}  // namespace concord::cartesian
