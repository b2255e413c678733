#include "cartesian/bodies/couplings.h"

#include <algorithm>

namespace concord::cartesian {

namespace {

/// Index of the coordinate that a term relates among those of its joint that are coupled.
int index_among(const std::vector<CoupledCoordinate>& coupled, const CouplingTerm& term) {
  const auto found = std::find_if(coupled.begin(), coupled.end(), [&](const CoupledCoordinate& other) {
    return other.word == term.word && other.component == term.component;
  });
  return static_cast<int>(found - coupled.begin());
}

}  // namespace

ByJoint<std::vector<CoupledCoordinate>> coupled_coordinates(const Model& model) {
  ByJoint<std::vector<CoupledCoordinate>> all(model.joints.size());
  for (const Coupling& stated : model.couplings) {
    for (const CouplingTerm& term : stated.terms) {
      const JointIndex k(term.joint);
      std::vector<CoupledCoordinate>& coupled = all[k];
      if (index_among(coupled, term) < static_cast<int>(coupled.size())) continue;
      const joints::JointType& type = *pick(model.joints, k).type;
      const int place = first_q(type, term.word) + term.component;
      const joints::Read* read = read_of(type, term.word);
      coupled.push_back({read, term.word, term.component, place, reads_turn(*read, term.component), 0.0});
    }
  }
  return all;
}

CouplingEquations make_coupling_equations(const Model& model, const Coupling& stated, const Layout& layout,
                                          RowIndex row, ByJoint<JointEquations>& joints) {
  CouplingEquations coupling;
  coupling.row = row;
  coupling.offset = stated.offset;
  for (const CouplingTerm& term : stated.terms) {
    const JointIndex k(term.joint);
    JointEquations& joint = joints[k];
    coupling.terms.push_back({k, joint.n_rows + index_among(joint.coupled, term), term.factor});
    joint.shares.push_back({coupling.terms.back().row, row, term.factor});
    for (const Attachment& side : pick(model.joints, k).sides) {
      const BodyIndex body = body_of(side);
      const bool is_new = std::count(coupling.bodies.begin(), coupling.bodies.end(), body) == 0;
      if (!is_ground(body) && is_new) coupling.bodies.push_back(body);
    }
  }
  for (const BodyIndex body : coupling.bodies)
    coupling.Phi_Y_transposed.emplace_back(MatX::Zero(layout.size_Y(body), 1));
  return coupling;
}

/// A body may sit in several of the coupled joints: its columns add up (C30).
void place_coupling(const Model& model, const ByJoint<JointEquations>& joints, CouplingEquations& coupling) {
  for (MatX& columns : coupling.Phi_Y_transposed) columns.setZero();
  for (const CouplingEquations::Term& term : coupling.terms) {
    for (const Side side : {Side::parent, Side::child}) {
      const BodyIndex body = body_of(pick(model.joints, term.joint).on(side));
      if (is_ground(body)) continue;
      const auto share = std::find(coupling.bodies.begin(), coupling.bodies.end(), body) - coupling.bodies.begin();
      coupling.Phi_Y_transposed[share].col(0) +=
          term.factor * joints[term.joint].Phi_Y_transposed[index(side)].col(term.row);
    }
  }
}

/// Whole turns and offset are summed apart: the rest has the round-off of one turn.
double residual_of(const CouplingEquations& coupling, const ByJoint<JointEquations>& joints) {
  long double turned = -static_cast<long double>(coupling.offset);
  double sum = 0.0;
  for (const CouplingEquations::Term& term : coupling.terms) {
    const JointEquations& joint = joints[term.joint];
    const CoupledCoordinate& coordinate = joint.coupled[term.row - joint.n_rows];
    if (coordinate.turns) turned += term.factor * whole_turns_between(joint.rows[term.row].value, coordinate.known);
    sum += term.factor * joint.rows[term.row].value;
  }
  return sum + static_cast<double>(turned);
}

double rate_of(const CouplingEquations& coupling, const ByJoint<JointEquations>& joints) {
  double sum = 0.0;
  for (const auto& term : coupling.terms) {
    const JointEquations& joint = joints[term.joint];
    sum += term.factor * rate_of(joint.rows[term.row], joint.motion);
  }
  return sum;
}

double bias_of(const CouplingEquations& coupling, const ByJoint<JointEquations>& joints) {
  double rest = 0.0;
  for (const auto& term : coupling.terms) {
    const JointEquations& joint = joints[term.joint];
    rest += term.factor * joint.bias_of(joint.rows[term.row]);
  }
  return rest;
}

double coupled_value(const JointEquations& joint, int row) {
  const CoupledCoordinate& coordinate = joint.coupled[row - joint.n_rows];
  return value_near(coordinate.turns, joint.rows[row], coordinate.known);
}

VecX joint_multipliers(const JointEquations& joint, const Eigen::Ref<const VecX>& lambda) {
  VecX own = VecX::Zero(static_cast<Eigen::Index>(joint.rows.size()));
  own.head(joint.n_rows) = lambda.segment(joint.first_row.value, joint.n_rows);
  for (const CoupledShare& share : joint.shares) own(share.row) += share.factor * lambda(share.coupling_row.value);
  return own;
}

}  // namespace concord::cartesian
