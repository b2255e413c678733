#include "cartesian/bodies/constraints.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "cartesian/bodies/euler_parameters.h"

namespace concord::cartesian {

std::unique_ptr<Constraints> Constraints::make(const Model& model, const Layout& layout) {
  return std::unique_ptr<Constraints>(new MovingConstraints(model, layout));
}

Constraints::Constraints(const Model& model, const Layout& layout)
    : model_(model), layout_(layout), rotations_(model.bodies.size(), Mat3::Identity()) {
  add_joints();
  add_couplings();
  add_blocks();
}

void Constraints::add_joints() {
  ByJoint<std::vector<CoupledCoordinate>> coupled = coupled_coordinates(model_);
  for (const JointIndex k : indices_of(model_.joints)) {
    joints_.add(make_joint_equations(pick(model_.joints, k), layout_, RowIndex(n_rows_), std::move(coupled[k])));
    const JointEquations& joint = joints_[k];
    for (int own = 0; own < joint.n_rows; ++own) {
      holds_positions_.push_back(own < joint.n_forbids || joint.is_driver(own));
      is_driver_.push_back(joint.is_driver(own));
    }
    n_rows_ += joint.n_rows;
  }
}

void Constraints::add_couplings() {
  for (const Coupling& stated : model_.couplings) {
    couplings_.add(make_coupling_equations(model_, stated, layout_, RowIndex(n_rows_++), joints_));
    holds_positions_.push_back(true);
    is_driver_.push_back(false);
  }
}

void Constraints::add_blocks() {
  for (const JointIndex k : joints()) {
    const JointEquations& joint = joints_[k];
    for (const Side side : {Side::parent, Side::child}) {
      const BodyIndex body = body_of(pick(model_.joints, k).on(side));
      if (is_ground(body) || joint.n_rows == 0) continue;
      blocks_.push_back({body, joint.first_row, joint.n_rows, RowBlock::OfJoint{k, side}});
    }
  }
  for (const CouplingIndex g : couplings()) {
    const CouplingEquations& coupling = couplings_[g];
    for (std::size_t share = 0; share < coupling.bodies.size(); ++share) {
      blocks_.push_back({coupling.bodies[share], coupling.row, 1, RowBlock::OfCoupling{g, static_cast<int>(share)}});
    }
  }
}

bool Constraints::has_nonholonomic_rows() const {
  return std::find(holds_positions_.begin(), holds_positions_.end(), false) != holds_positions_.end();
}

std::string Constraints::name_of(RowIndex wanted) const {
  for (const JointIndex k : joints()) {
    const JointEquations& joint = joints_[k];
    if (wanted >= joint.first_row && wanted < joint.row(joint.n_rows)) {
      return fmt::format("joint '{}'", pick(model_.joints, k).name);
    }
  }
  for (const CouplingIndex g : couplings()) {
    if (wanted == couplings_[g].row) return fmt::format("coupling '{}'", pick(model_.couplings, g).name);
  }
  return {};
}

void Constraints::place_body(BodyIndex body, const Eigen::Ref<const VecX>& q) {
  rotations_[body] = rotation_of(layout_.p(q, body));
}

PlacedConstraints& Constraints::place(const Eigen::Ref<const VecX>& q) {
  for (const BodyIndex i : layout_.moving_bodies()) place_body(i, q);
  for (const JointIndex k : joints()) place_joint(pick(model_.joints, k), layout_, rotations_, q, joints_[k]);
  for (CouplingEquations& coupling : couplings_) place_coupling(model_, joints_, coupling);
  return static_cast<PlacedConstraints&>(*this);
}

MovingConstraints& Constraints::place_and_move(const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y) {
  for (const BodyIndex i : layout_.moving_bodies()) place_body(i, q);
  for (const JointIndex k : joints()) {
    place_and_move_joint(pick(model_.joints, k), layout_, rotations_, q, Y, joints_[k]);
  }
  for (CouplingEquations& coupling : couplings_) place_coupling(model_, joints_, coupling);
  return static_cast<MovingConstraints&>(*this);
}

MovingConstraints& PlacedConstraints::move(const Eigen::Ref<const VecX>& Y) {
  for (const JointIndex k : joints()) move_joint(pick(model_.joints, k), layout_, rotations_, Y, joints_[k]);
  return static_cast<MovingConstraints&>(*this);
}

void MovingConstraints::displace(JointIndex joint, BodyIndex body, const Eigen::Ref<const VecX>& q,
                                 const Eigen::Ref<const VecX>& Y) {
  place_body(body, q);
  place_and_move_joint(pick(model_.joints, joint), layout_, rotations_, q, Y, joints_[joint]);
}

void MovingConstraints::displace(const RowBlock& block, const Eigen::Ref<const VecX>& q,
                                 const Eigen::Ref<const VecX>& Y) {
  if (const auto* of = std::get_if<RowBlock::OfJoint>(&block.owner)) {
    displace(of->joint, block.body, q, Y);
    return;
  }
  const auto& of = std::get<RowBlock::OfCoupling>(block.owner);
  for (const CouplingEquations::Term& term : couplings_[of.coupling].terms) {
    displace(term.joint, block.body, q, Y);
  }
}

void Constraints::count_turns_from(const std::vector<VecX>& q) {
  for (const JointIndex k : joints()) {
    for (CoupledCoordinate& coordinate : joints_[k].coupled) coordinate.known = q[k.value](coordinate.place);
    if (!joints_[k].elevation) continue;
    joints_[k].motion.is_beyond_upright = std::cos(q[k.value](*joints_[k].elevation)) < 0.0;
  }
}

void Constraints::count_turns_as(const Constraints& other) {
  for (const JointIndex k : joints()) {
    JointEquations& joint = joints_[k];
    const JointEquations& known = other.joints_[k];
    for (std::size_t c = 0; c < joint.coupled.size(); ++c) joint.coupled[c].known = known.coupled[c].known;
    joint.motion.is_beyond_upright = known.motion.is_beyond_upright;
  }
}

void PlacedConstraints::follow_turns() {
  for (JointEquations& joint : joints_) {
    for (std::size_t c = 0; c < joint.coupled.size(); ++c) {
      joint.coupled[c].known = coupled_value(joint, joint.n_rows + static_cast<int>(c));
    }
  }
}

void Constraints::write_turns(std::vector<VecX>& q) const {
  for (const JointIndex k : joints()) {
    for (const CoupledCoordinate& coordinate : joints_[k].coupled) q[k.value](coordinate.place) = coordinate.known;
  }
}

void PlacedConstraints::write_own_terms(double t, Eigen::Ref<VecX> terms) const {
  terms.setZero();
  for (const JointIndex k : joints()) {
    const JointEquations& joint = joints_[k];
    for (int own = joint.first_driver; own < joint.n_rows; ++own) {
      if (joint.driver_turns[own - joint.first_driver]) continue;
      const Driver& driver = pick(model_.joints, k).drivers[own - joint.first_driver];
      terms(joint.row(own).value) = std::abs(evaluate(driver.law, t).f);
    }
  }
  for (const CouplingEquations& coupling : couplings_) {
    double largest = 0.0;
    for (const CouplingEquations::Term& term : coupling.terms) {
      largest = std::max(largest, std::abs(term.factor * joints_[term.joint].rows[term.row].value));
    }
    terms(coupling.row.value) = largest;
  }
}

void PlacedConstraints::write_reaches(double reach, Eigen::Ref<VecX> reaches) const {
  const auto of = [reach](const ConstraintRow& row) { return row.reads_places() ? reach : 1.0; };
  for (const JointEquations& joint : joints_) {
    for (int own = 0; own < joint.n_rows; ++own) reaches(joint.row(own).value) = of(joint.rows[own]);
  }
  for (const CouplingEquations& coupling : couplings_) {
    double& largest = reaches(coupling.row.value);
    largest = 1.0;
    for (const CouplingEquations::Term& term : coupling.terms) {
      largest = std::max(largest, of(joints_[term.joint].rows[term.row]));
    }
  }
}

Eigen::Ref<const MatX> PlacedConstraints::columns(const RowBlock& block) const {
  if (const auto* of = std::get_if<RowBlock::OfJoint>(&block.owner)) {
    return joints_[of->joint].Phi_Y_transposed[index(of->side)].leftCols(block.n_rows);
  }
  const auto& of = std::get<RowBlock::OfCoupling>(block.owner);
  return couplings_[of.coupling].Phi_Y_transposed[of.share];
}

void PlacedConstraints::write_residual(double t, Eigen::Ref<VecX> residual) const {
  for (const JointIndex k : joints()) {
    const JointEquations& joint = joints_[k];
    const Joint& stated = pick(model_.joints, k);
    for (int own = 0; own < joint.first_driver; ++own) residual(joint.row(own).value) = joint.rows[own].value;
    for (int own = joint.first_driver; own < joint.n_rows; ++own) {
      const Driver& driver = stated.drivers[own - joint.first_driver];
      const double value = joint.rows[own].value;
      const double asked = evaluate(driver.law, t).f;
      residual(joint.row(own).value) =
          joint.driver_turns[own - joint.first_driver] ? turn_from(asked, value) : value - asked;
    }
  }
  for (const CouplingEquations& coupling : couplings_) residual(coupling.row.value) = residual_of(coupling, joints_);
}

void MovingConstraints::write_velocity_residual(double t, Eigen::Ref<VecX> residual) const {
  for (const JointIndex k : joints()) {
    const JointEquations& joint = joints_[k];
    const Joint& stated = pick(model_.joints, k);
    for (int own = 0; own < joint.n_rows; ++own) {
      double rate = rate_of(joint.rows[own], joint.motion);
      if (joint.is_driver(own)) rate -= evaluate(stated.drivers[own - joint.first_driver].law, t).fdot;
      residual(joint.row(own).value) = rate;
    }
  }
  for (const CouplingEquations& coupling : couplings_) residual(coupling.row.value) = rate_of(coupling, joints_);
}

double MovingConstraints::row_rate(const RowBlock& block, int own) const {
  if (const auto* of = std::get_if<RowBlock::OfJoint>(&block.owner)) {
    const JointEquations& joint = joints_[of->joint];
    return rate_of(joint.rows[own], joint.motion);
  }
  return rate_of(couplings_[std::get<RowBlock::OfCoupling>(block.owner).coupling], joints_);
}

void MovingConstraints::write_gamma(double t, Eigen::Ref<VecX> gamma) const {
  for (const JointIndex k : joints()) {
    const JointEquations& joint = joints_[k];
    const Joint& stated = pick(model_.joints, k);
    for (int own = 0; own < joint.n_rows; ++own) {
      double rest = joint.bias_of(joint.rows[own]);
      if (joint.is_driver(own)) rest -= evaluate(stated.drivers[own - joint.first_driver].law, t).fddot;
      gamma(joint.row(own).value) = -rest;
    }
  }
  for (const CouplingEquations& coupling : couplings_) gamma(coupling.row.value) = -bias_of(coupling, joints_);
}

std::optional<JointIndex> PlacedConstraints::first_joint_off_branch() const {
  for (const JointIndex k : joints()) {
    if (!on_branch(*pick(model_.joints, k).type, joints_[k].motion)) return k;
  }
  return std::nullopt;
}

}  // namespace concord::cartesian
