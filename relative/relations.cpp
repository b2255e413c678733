#include "relative/relations.h"

#include <algorithm>
#include <cmath>

namespace concord::relative {

namespace {

int place_in_u(const CouplingTerm& term, const Joint& joint) {
  return first_u(*joint.type, term.word) + term.component;
}

int place_in_q(const CouplingTerm& term, const Kinematics& kinematics) {
  const joints::JointType& type = *kinematics.model().joints[term.joint].type;
  return kinematics.topology().joints[term.joint].first_q + first_q(type, term.word) + term.component;
}

int place_of(const std::vector<int>& joints, int joint) {
  const auto found = std::find(joints.begin(), joints.end(), joint);
  return found == joints.end() ? -1 : static_cast<int>(found - joints.begin());
}

int link_of(const Topology& topology, int joint) {
  const auto found = std::find_if(topology.links.begin(), topology.links.end(),
                                  [joint](const Link& link) { return link.joint == joint; });
  return found == topology.links.end() ? -1 : static_cast<int>(found - topology.links.begin());
}

}  // namespace

double size_of(const Coupling& coupling, const Model& model, double length) {
  double sum = 0.0;
  for (const CouplingTerm& term : coupling.terms) {
    const Joint& joint = model.joints[term.joint];
    const bool slides = Motion(*joint.type).kind(place_in_u(term, joint)).is_length;
    sum += std::pow(term.factor * (slides ? length : 1.0), 2);
  }
  return std::sqrt(sum);
}

double compute_gap(const Coupling& coupling, const Kinematics& kinematics, const VecX& q) {
  double gap = 0.0;
  long double turned = -static_cast<long double>(coupling.offset);  // whole turns cancel against the offset
  for (const CouplingTerm& term : coupling.terms) {
    const int place = place_in_q(term, kinematics);
    gap += term.factor * q(place);
    turned += term.factor * (kWholeTurn * kinematics.turns()(place));
  }
  return gap + static_cast<double>(turned);
}

double size_of_terms(const Coupling& coupling, const Kinematics& kinematics, const VecX& q) {
  double largest = 0.0;
  for (const CouplingTerm& term : coupling.terms) {
    largest = std::max(largest, std::abs(term.factor * q(place_in_q(term, kinematics))));
  }
  return largest;
}

double compute_slip(const Coupling& coupling, const Model& model, const Topology& topology, const VecX& u) {
  double slip = 0.0;
  for (const CouplingTerm& term : coupling.terms) {
    slip += term.factor * u(topology.joints[term.joint].first_u + place_in_u(term, model.joints[term.joint]));
  }
  return slip;
}

Relations::Relations(const Kinematics& kinematics, const Held& held, int first_row)
    : kinematics_(&kinematics), held_(held), first_row_(first_row) {
  const Model& model = kinematics.model();
  for (std::size_t g = 0; g < model.couplings.size(); ++g) add_coupling(static_cast<int>(g));
  n_position_rows_ = n_rows_;
  for (std::size_t k = 0; k < model.joints.size(); ++k) add_constraint_of_velocity(static_cast<int>(k));
}

RelatedJoint& Relations::part_of(Relation& relation, int joint) {
  for (RelatedJoint& part : relation.joints) {
    if (part.joint == joint) return part;
  }
  const Topology& topology = kinematics_->topology();
  const int n_u = topology.joints[joint].n_u;
  relation.joints.push_back({joint, place_of(topology.cuts, joint), link_of(topology, joint),
                             JointSquare::Zero(n_u, relation.n_rows), JointColumns::Zero(6, relation.n_rows),
                             JointColumns::Zero(6, relation.n_rows)});
  return relation.joints.back();
}

void Relations::add_coupling(int number) {  // (R49)
  const Model& model = kinematics_->model();
  const Coupling& coupling = model.couplings[number];
  Relation relation{first_row_ + n_rows_, 1, number, size_of(coupling, model, machine_length(model)), {},
                    JointVector::Zero(1)};
  for (const CouplingTerm& term : coupling.terms) {
    part_of(relation, term.joint).C(place_in_u(term, model.joints[term.joint]), 0) = term.factor / relation.size;
  }
  relations_.push_back(std::move(relation));
  n_rows_ += 1;
}

void Relations::add_constraint_of_velocity(int joint) {
  PermittedSpeeds permitted(*kinematics_->model().joints[joint].type, kinematics_->motion(joint));
  if (permitted.n_rows() == 0) return;
  Relation relation{first_row_ + n_rows_, permitted.n_rows(), -1, 1.0, {}, JointVector::Zero(permitted.n_rows())};
  part_of(relation, joint);
  n_rows_ += relation.n_rows;
  relations_.push_back(std::move(relation));
  permitted_.push_back(std::move(permitted));
}

bool Relations::is_held(const RelatedJoint& part, int c) const {
  return held_[kinematics_->topology().joints[part.joint].first_u + c] != 0;
}

const JointMotion& Relations::motion_of(const RelatedJoint& part, const std::vector<CutJoint>& cuts) const {
  return part.cut < 0 ? kinematics_->joint_motion(part.joint) : cuts[part.cut].measure.motion_at();
}

/// The wrenches of a cut joint's rows, and what is left of its velocity beside S u, seen along them (R50).
void Relations::measure_cut(RelatedJoint& part, const CutJoint& cut, VecX::SegmentReturnType slip_rows) {
  const JointPoint& parent = kinematics_->point(part.joint, Side::parent);
  for (Eigen::Index row = 0; row < part.C.cols(); ++row) {
    JointVector tau = part.C.col(row);
    for (int c = 0; c < static_cast<int>(tau.size()); ++c) {
      if (is_held(part, c)) tau(c) = 0.0;
    }
    const Vec6 w = kinematics_->motion(part.joint).coordinate_wrench(cut.measure.motion_at(), tau);
    part.T.col(row) = w;
    part.T_global.col(row) << parent.A * w.head<3>(), parent.A * w.tail<3>();
    slip_rows(row) += w.dot(cut.measure.slip());
  }
}

void Relations::measure(const std::vector<CutJoint>& cuts, const VecX& q, const VecX& u, VecX& gap, VecX& slip) {
  const Model& model = kinematics_->model();
  std::size_t constraint = 0;
  for (Relation& relation : relations_) {
    if (!relation.is_coupling()) {
      RelatedJoint& part = relation.joints.front();
      PermittedSpeeds& permitted = permitted_[constraint++];
      permitted.evaluate(motion_of(part, cuts), model.joints[part.joint].name);
      part.C = permitted.C();
      relation.bias = permitted.bias();
    }
    auto slip_rows = slip.segment(relation.first_row, relation.n_rows);
    slip_rows.setZero();
    for (RelatedJoint& part : relation.joints) {
      const Span& span = kinematics_->topology().joints[part.joint];
      slip_rows.noalias() += part.C.transpose().lazyProduct(u.segment(span.first_u, span.n_u));
      if (part.cut >= 0) measure_cut(part, cuts[part.cut], slip_rows);
    }
    if (!relation.is_coupling()) continue;
    // The coordinates of a cut joint that is not closed yet: measured along the wrenches by which they move.
    double& found = gap(relation.first_row);
    found = compute_gap(model.couplings[relation.coupling], *kinematics_, q) / relation.size;
    for (const RelatedJoint& part : relation.joints) {
      if (part.cut >= 0) found += part.T.col(0).dot(cuts[part.cut].measure.error());
    }
  }
}

}  // namespace concord::relative
