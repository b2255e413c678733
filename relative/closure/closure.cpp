#include "relative/closure/closure.h"

#include <fmt/format.h>

namespace concord::relative {

MatX rows_on_body(const JointPoint& point, const Mat6X& wrenches) {
  MatX rows(wrenches.cols(), 6 + point.n_modes());
  for (Eigen::Index k = 0; k < wrenches.cols(); ++k) {
    rows.row(k).head<6>() = shift_wrench(wrenches.col(k), point.lever).transpose();
  }
  rows.rightCols(point.n_modes()) = wrenches.transpose() * point.Ga();
  return rows;
}

namespace {

std::vector<CutJoint> lay_out_cuts(const Kinematics& kinematics, const PrescribedMask& prescribed) {
  std::vector<CutJoint> cuts;
  int rows = 0;
  for (const JointIndex k : kinematics.topology().cuts) {
    cuts.push_back(
        {k, RowIndex(rows),
         JointMeasure(kinematics.mobilizer(k), prescribed.data() + kinematics.topology().joints[k].first_u)});
    rows += cuts.back().measure.n_rows();
  }
  return cuts;
}

int count_rows(const std::vector<CutJoint>& cuts) {
  return cuts.empty() ? 0 : cuts.back().first_row + cuts.back().measure.n_rows();
}

}  // namespace

Closure::Closure(const Kinematics& kinematics, const PrescribedMask& prescribed)
    : kinematics_(&kinematics),
      prescribed_(prescribed),
      cuts_(lay_out_cuts(kinematics, prescribed)),
      speed_constraints_(kinematics, prescribed, count_rows(cuts_)),
      position_residual_(VecX::Zero(count_rows(cuts_) + speed_constraints_.n_position_rows())),
      velocity_residual_(VecX::Zero(count_rows(cuts_) + speed_constraints_.n_rows())),
      row_units_(VecX::Ones(velocity_residual_.size())) {
  for (const Cut& cut : cuts_) {
    row_units_.segment(cut.first_row, cut.measure.n_linear_rows())
        .setConstant(kinematics.mobilizer(cut.joint).length());
  }
}

void Closure::measure(VecX& q, VecX& u) {
  for (Cut& cut : cuts_) {
    const JointPoint& parent = kinematics_->point(cut.joint, Side::parent);
    const JointPoint& child = kinematics_->point(cut.joint, Side::child);
    const Span& span = kinematics_->topology().joints[cut.joint];
    cut.measure.find_q(parent, child, q.data() + span.first_q, JointMeasure::Restart::never);
    kinematics_->require_rank(cut.joint, cut.measure.motion_at());
    cut.measure.find_u(parent, child, q.data() + span.first_q, u.data() + span.first_u);
    const int rows = cut.measure.n_rows();
    const auto T = cut.measure.T().leftCols(rows);
    position_residual_.segment(cut.first_row, rows).noalias() =
        T.transpose().lazyProduct(cut.measure.position_residual());
    velocity_residual_.segment(cut.first_row, rows).noalias() =
        T.transpose().lazyProduct(cut.measure.velocity_residual());
    cut.T_global.topRows<3>().noalias() = parent.A.lazyProduct(cut.measure.T().topRows<3>());
    cut.T_global.bottomRows<3>().noalias() = parent.A.lazyProduct(cut.measure.T().bottomRows<3>());
  }
  if (speed_constraints_.any()) speed_constraints_.measure(cuts_, q, u, position_residual_, velocity_residual_);
}

/// a_rel: the time derivative of the components of v_rel in the parent's joint frame (R45).
Vec6 Closure::relative_acceleration(const Cut& cut, const Vec6& of_parent, const Vec6& of_child) const {
  const JointPoint& parent = kinematics_->point(cut.joint, Side::parent);
  const JointPoint& child = kinematics_->point(cut.joint, Side::child);
  const Vec3 d = child.r - parent.r;
  const Vec3 sliding_velocity = child.v - parent.v - parent.omega.cross(d);
  Vec6 a_rel = of_child - shift_motion(of_parent, d);
  a_rel.head<3>() -= parent.omega.cross(parent.omega.cross(d) + 2.0 * sliding_velocity);
  a_rel.tail<3>() -= parent.omega.cross(child.omega - parent.omega);
  a_rel.head<3>() = (parent.A.transpose() * a_rel.head<3>()).eval();
  a_rel.tail<3>() = (parent.A.transpose() * a_rel.tail<3>()).eval();
  return a_rel;
}

/// Adds what wrenches on the child of a joint (6 x rows, global axes), and the opposite ones on its parent, do on the
/// tree's speeds.
void Closure::add_wrench_rows(JointIndex joint, const Mat6X& on_child, MatX& rows) const {
  const Joint& statement = kinematics_->model().joints[joint];
  const JointPoint& parent = kinematics_->point(joint, Side::parent);
  const JointPoint& child = kinematics_->point(joint, Side::child);
  Mat6X on_parent(6, on_child.cols());
  for (Eigen::Index k = 0; k < on_child.cols(); ++k) {
    on_parent.col(k) = -shift_wrench(on_child.col(k), child.r - parent.r);
  }
  kinematics_->add_times_B(BodyIndex(statement.on(Side::child).body), rows_on_body(child, on_child), rows);
  kinematics_->add_times_B(BodyIndex(statement.on(Side::parent).body), rows_on_body(parent, on_parent), rows);
}

MatX Closure::Phi_u() const {
  MatX Phi = MatX::Zero(n_rows(), kinematics_->topology().n_tree_u);
  for (const Cut& cut : cuts_) {
    const int rows = cut.measure.n_rows();
    MatX block = MatX::Zero(rows, Phi.cols());
    add_wrench_rows(cut.joint, cut.T_global.leftCols(rows), block);
    Phi.middleRows(cut.first_row, rows) = block;
  }
  for (const SpeedConstraint& constraint : speed_constraints_.all()) {
    MatX block = MatX::Zero(constraint.n_rows, Phi.cols());
    for (const ConstrainedJoint& part : constraint.joints) {
      const Span& span = kinematics_->topology().joints[part.joint];
      if (part.cut()) {
        add_wrench_rows(part.joint, part.T_global, block);
      } else {
        block.middleCols(span.first_u, span.n_u) += part.C.transpose();
      }
    }
    Phi.middleRows(constraint.first_row, constraint.n_rows) = block;
  }
  return Phi;
}

std::string Closure::worst_place(const VecX& rows) const {
  Eigen::Index worst = 0;
  rows.cwiseAbs().maxCoeff(&worst);
  const Model& model = kinematics_->model();
  std::string place;
  for (const Cut& cut : cuts_) {
    if (cut.first_row <= worst) place = fmt::format("the loop of joint '{}'", model.joints[cut.joint].name);
  }
  for (const SpeedConstraint& constraint : speed_constraints_.all()) {
    if (constraint.first_row > worst) continue;
    place = constraint.is_coupling()
                ? fmt::format("coupling '{}'", model.couplings[*constraint.coupling].name)
                : fmt::format("the velocity of joint '{}'", model.joints[constraint.joints.front().joint].name);
  }
  return place;
}

}  // namespace concord::relative
