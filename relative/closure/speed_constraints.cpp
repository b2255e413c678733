#include "relative/closure/speed_constraints.h"

#include <algorithm>
#include <cmath>

namespace concord::relative {

namespace {

int index_in_u(const CouplingTerm& term, const Joint& joint) {
  return first_u(*joint.type, term.word) + term.component;
}

int index_in_q(const CouplingTerm& term, const Kinematics& kinematics) {
  const joints::JointType& type = *kinematics.model().joints[term.joint].type;
  return kinematics.topology().joints[term.joint].first_q + first_q(type, term.word) + term.component;
}

}  // namespace

double size_of(const Coupling& coupling, const Kinematics& kinematics) {
  double sum = 0.0;
  for (const CouplingTerm& term : coupling.terms) {
    const int place =
        kinematics.topology().joints[term.joint].first_u + index_in_u(term, kinematics.model().joints[term.joint]);
    sum += std::pow(term.factor * kinematics.size().speeds()(place), 2);
  }
  return std::sqrt(sum);
}

double compute_position_residual(const Coupling& coupling, const Kinematics& kinematics, const VecX& q) {
  double position_residual = 0.0;
  long double turned = -static_cast<long double>(coupling.offset);  // whole turns cancel against the offset
  for (const CouplingTerm& term : coupling.terms) {
    const int place = index_in_q(term, kinematics);
    position_residual += term.factor * q(place);
    turned += term.factor * (kWholeTurn * kinematics.turns()(place));
  }
  return position_residual + static_cast<double>(turned);
}

double size_of_terms(const Coupling& coupling, const Kinematics& kinematics, const VecX& q) {
  double largest = 0.0;
  for (const CouplingTerm& term : coupling.terms) {
    largest = std::max(largest, std::abs(term.factor * q(index_in_q(term, kinematics))));
  }
  return largest;
}

double size_of_turns(const Coupling& coupling, const Kinematics& kinematics) {
  double largest = 0.0;
  for (const CouplingTerm& term : coupling.terms) {
    largest = std::max(largest, std::abs(term.factor * static_cast<double>(kWholeTurn) *
                                         kinematics.turns()(index_in_q(term, kinematics))));
  }
  return largest;
}

double compute_velocity_residual(const Coupling& coupling, const Model& model, const Topology& topology,
                                 const VecX& u) {
  double velocity_residual = 0.0;
  for (const CouplingTerm& term : coupling.terms) {
    velocity_residual +=
        term.factor * u(topology.joints[term.joint].first_u + index_in_u(term, model.joints[term.joint]));
  }
  return velocity_residual;
}

SpeedConstraints::SpeedConstraints(const Kinematics& kinematics, const PrescribedMask& prescribed, int first_row)
    : kinematics_(&kinematics), prescribed_(prescribed), first_row_(first_row) {
  const Model& model = kinematics.model();
  for (std::size_t g = 0; g < model.couplings.size(); ++g) add_coupling(static_cast<int>(g));
  n_position_rows_ = n_rows_;
  for (const JointIndex k : upward<JointIndex>(model.joints.size())) add_nonholonomic(k);
}

ConstrainedJoint& SpeedConstraints::part_of(SpeedConstraint& constraint, JointIndex joint) {
  for (ConstrainedJoint& part : constraint.joints) {
    if (part.joint == joint) return part;
  }
  const Topology& topology = kinematics_->topology();
  const int n_u = topology.joints[joint].n_u;
  constraint.joints.push_back({joint, topology.places[joint], JointSquare::Zero(n_u, constraint.n_rows),
                               JointColumns::Zero(6, constraint.n_rows), JointColumns::Zero(6, constraint.n_rows)});
  return constraint.joints.back();
}

void SpeedConstraints::add_coupling(int number) {  // (R49)
  const Model& model = kinematics_->model();
  const Coupling& coupling = model.couplings[number];
  SpeedConstraint constraint{RowIndex(first_row_ + n_rows_),  1,  number,
                             size_of(coupling, *kinematics_), {}, JointVector::Zero(1)};
  for (const CouplingTerm& term : coupling.terms) {
    const JointIndex joint(term.joint);
    part_of(constraint, joint).C(index_in_u(term, model.joints[joint]), 0) = term.factor / constraint.size;
  }
  constraints_.push_back(std::move(constraint));
  n_rows_ += 1;
}

void SpeedConstraints::add_nonholonomic(JointIndex joint) {
  NonholonomicConstraint permitted(*kinematics_->model().joints[joint].type, kinematics_->mobilizer(joint));
  if (permitted.n_rows() == 0) return;
  SpeedConstraint constraint{RowIndex(first_row_ + n_rows_),       permitted.n_rows(), std::nullopt, 1.0, {},
                             JointVector::Zero(permitted.n_rows())};
  part_of(constraint, joint);
  n_rows_ += constraint.n_rows;
  constraints_.push_back(std::move(constraint));
  nonholonomic_.push_back(std::move(permitted));
}

bool SpeedConstraints::is_prescribed(const ConstrainedJoint& part, int c) const {
  return prescribed_[kinematics_->topology().joints[part.joint].first_u + c] != 0;
}

const JointMotion& SpeedConstraints::motion_of(const ConstrainedJoint& part, const std::vector<CutJoint>& cuts) const {
  const std::optional<CutIndex> cut = part.cut();
  return cut ? cuts[*cut].measure.motion_at() : kinematics_->joint_motion(part.joint);
}

/// The wrenches of a cut joint's rows, and what is left of its velocity beside S u, seen along them (R50).
void SpeedConstraints::measure_cut(ConstrainedJoint& part, const CutJoint& cut, VecX::SegmentReturnType velocity_rows) {
  const JointPoint& parent = kinematics_->point(part.joint, Side::parent);
  for (Eigen::Index row = 0; row < part.C.cols(); ++row) {
    JointVector tau = part.C.col(row);
    for (int c = 0; c < static_cast<int>(tau.size()); ++c) {
      if (is_prescribed(part, c)) tau(c) = 0.0;
    }
    const Vec6 w = kinematics_->mobilizer(part.joint).coordinate_wrench(cut.measure.motion_at(), tau);
    part.T.col(row) = w;
    part.T_global.col(row) << parent.A * w.head<3>(), parent.A * w.tail<3>();
    velocity_rows(row) += w.dot(cut.measure.velocity_residual());
  }
}

void SpeedConstraints::measure(const std::vector<CutJoint>& cuts, const VecX& q, const VecX& u, VecX& position_residual,
                               VecX& velocity_residual) {
  const Model& model = kinematics_->model();
  std::size_t next_nonholonomic = 0;
  for (SpeedConstraint& constraint : constraints_) {
    if (!constraint.is_coupling()) {
      ConstrainedJoint& part = constraint.joints.front();
      NonholonomicConstraint& permitted = nonholonomic_[next_nonholonomic++];
      permitted.evaluate(motion_of(part, cuts), model.joints[part.joint].name);
      part.C = permitted.C();
      constraint.bias = permitted.bias();
    }
    auto velocity_rows = velocity_residual.segment(constraint.first_row, constraint.n_rows);
    velocity_rows.setZero();
    for (ConstrainedJoint& part : constraint.joints) {
      const Span& span = kinematics_->topology().joints[part.joint];
      velocity_rows.noalias() += part.C.transpose().lazyProduct(u.segment(span.first_u, span.n_u));
      if (const auto cut = part.cut()) measure_cut(part, cuts[*cut], velocity_rows);
    }
    if (!constraint.is_coupling()) continue;
    // The coordinates of a cut joint that is not closed yet: measured along the wrenches by which they move.
    double& found = position_residual(constraint.first_row.value());
    found = compute_position_residual(model.couplings[*constraint.coupling], *kinematics_, q) / constraint.size;
    for (const ConstrainedJoint& part : constraint.joints) {
      if (const auto cut = part.cut()) found += part.T.col(0).dot(cuts[*cut].measure.position_residual());
    }
  }
}

}  // namespace concord::relative
