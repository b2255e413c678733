#include "compare/random_machines/velocities.h"

#include "common/decompositions.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/referee.h"

namespace concord::compare::fuzz {

Pose frame_of(const End& end, const Pose& body) { return {body.r + body.A * end.point, body.A * rotation_of(end.p)}; }

Motion motion_of(const JointPlan& joint, const joints::JointType& type) {
  return referee_permits(type, joint.q, joint.u);
}

Side outer_side(const JointPlan& joint, int body) { return joint.ends[1].body == body ? Side::child : Side::parent; }

void append_rows(MatX& rows, const MatX& more) {
  const Eigen::Index old = rows.rows();
  rows.conservativeResize(old + more.rows(), more.cols());
  rows.bottomRows(more.rows()) = more;
}

Velocities::Velocities(const Machine& machine, const std::vector<Pose>& poses) : machine_(machine), poses_(poses) {
  for (const JointPlan& joint : machine.joints) {
    types_.push_back(joint.own_type());
    first_.push_back(n_);
    n_ += joint.type->n_u();
  }
  find_scales();
  move_tree();
}

MatX Velocities::loops() const {
  MatX rows(0, n_);
  for (std::size_t k = 0; k < machine_.joints.size(); ++k) {
    if (machine_.joints[k].closes_loop) append_rows(rows, loop_rows(static_cast<int>(k)));
  }
  return rows * scale_.asDiagonal();
}

MatX Velocities::slips() const {
  MatX rows(0, n_);
  for (std::size_t k = 0; k < machine_.joints.size(); ++k) {
    if (types_[k].permits_speeds.empty()) continue;
    const Motion motion = motion_of(machine_.joints[k], types_[k]);
    const auto n_u = types_[k].n_u();
    const MatX free = free_speeds(types_[k], motion.placement.R, motion.S.leftCols(n_u));
    const MatX forbidden = kernel_of(free.transpose()).transpose();
    MatX more = MatX::Zero(forbidden.rows(), n_);
    more.middleCols(first_[k], n_u) = forbidden;
    append_rows(rows, more);
  }
  rows = rows * scale_.asDiagonal();
  for (Eigen::Index k = 0; k < rows.rows(); ++k) rows.row(k).normalize();
  return rows;
}

void Velocities::find_scales() {
  scale_ = VecX::Ones(n_);
  for (std::size_t k = 0; k < types_.size(); ++k) {
    const std::vector<bool> turning = turning_speeds(types_[k]);
    for (std::size_t c = 0; c < turning.size(); ++c) {
      if (!turning[c]) scale_(first_[k] + static_cast<int>(c)) = machine_.length;
    }
  }
}

MatX Velocities::at_point(const Speeds& body, const Vec3& arm) const {
  MatX v = body.v;
  for (int c = 0; c < n_; ++c) v.col(c) += Vec3(body.omega.col(c)).cross(arm);
  return v;
}

/// Velocity and angular velocity of the child's frame against the parent's, in global axes, by the joint's speeds.
Velocities::Speeds Velocities::permitted(int k, const Motion& motion, const Mat3& A_joint) const {
  Speeds own{MatX::Zero(3, n_), MatX::Zero(3, n_)};
  const auto n_u = types_[k].n_u();
  own.v.middleCols(first_[k], n_u) = A_joint * motion.S.topRows<3>().leftCols(n_u);
  own.omega.middleCols(first_[k], n_u) = A_joint * motion.S.bottomRows<3>().leftCols(n_u);
  return own;
}

void Velocities::move_tree() {
  bodies_.resize(machine_.bodies.size());
  bodies_[0] = {MatX::Zero(3, n_), MatX::Zero(3, n_)};
  for (int i = 1; i < static_cast<int>(machine_.bodies.size()); ++i) {
    const JointPlan& joint = machine_.joints[i - 1];
    const Side outer = outer_side(joint, i);
    const End& outer_end = joint.ends[index(outer)];
    const End& inner_end = joint.ends[1 - index(outer)];
    const Pose outer_frame = frame_of(outer_end, poses_[i]);
    const Pose inner_frame = frame_of(inner_end, poses_[inner_end.body]);
    const Mat3 A_joint = outer == Side::child ? inner_frame.A : outer_frame.A;
    const Speeds own = permitted(i - 1, motion_of(joint, types_[i - 1]), A_joint);
    const double sign = outer == Side::child ? 1.0 : -1.0;
    const Speeds& inner = bodies_[inner_end.body];
    bodies_[i].omega = inner.omega + sign * own.omega;
    // ddot = v_Pi - v_Pj - omega_j x (r_Pi - r_Pj), whichever side is the outer one.
    MatX v = at_point(inner, inner_frame.r - poses_[inner_end.body].r) + sign * own.v;
    const MatX& omega_parent = outer == Side::child ? inner.omega : bodies_[i].omega;
    for (int c = 0; c < n_; ++c) v.col(c) += Vec3(omega_parent.col(c)).cross(outer_frame.r - inner_frame.r);
    bodies_[i].v = v;
    bodies_[i].v = at_point(bodies_[i], poses_[i].r - outer_frame.r);
  }
}

MatX Velocities::loop_rows(int k) const {
  const JointPlan& joint = machine_.joints[k];
  const Pose parent = frame_of(joint.ends[0], poses_[joint.ends[0].body]);
  const Pose child = frame_of(joint.ends[1], poses_[joint.ends[1].body]);
  const Speeds own = permitted(k, motion_of(joint, types_[k]), parent.A);
  const Speeds& j = bodies_[joint.ends[0].body];
  const Speeds& i = bodies_[joint.ends[1].body];
  MatX rows(6, n_);
  rows.topRows<3>() =
      at_point(i, child.r - poses_[joint.ends[1].body].r) - at_point(j, child.r - poses_[joint.ends[0].body].r) - own.v;
  rows.topRows<3>() /= machine_.length;
  rows.bottomRows<3>() = i.omega - j.omega - own.omega;
  return rows;
}

}  // namespace concord::compare::fuzz
