#include "compare/audit/balance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "common/decompositions.h"
#include "compare/audit/beam_statement.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/joint_power.h"
#include "compare/audit/places.h"
#include "compare/audit/round_off.h"

namespace concord::compare {

namespace {

constexpr std::array kComponentNames{"F_x", "F_y", "F_z", "T_x", "T_y", "T_z"};
constexpr std::array kOnSide{" on parent", " on child"};

/// Number of rows of all rules of a joint: workless (components, directions), two frames (reaction, total), both sides
/// (same), drivers (tau, coordinate wrench), force law (shares by laws, their sum).
int joint_rows(const joints::JointType& type) {
  const auto free = static_cast<int>(turning_free_speeds(type).size());
  return 12 + free + 2 * 12 + 2 * 6 + free + 6 + static_cast<int>(kActors.size()) * type.n_u();
}

/// Reaction components, parent's and child's, that the joint cannot carry; zero in place of the others.
VecX workless_residuals(const CarriedComponents& carried, const JointWrenches& wrenches) {
  VecX residuals(12);
  for (const Side side : kSides) {
    residuals.segment<6>(6 * index(side)) = wrenches.reaction_on(side).in_C.vector();
    for (int c = 0; c < 6; ++c) {
      if (carried[index(side)][c]) residuals(6 * index(side) + c) = 0.0;
    }
  }
  return residuals;
}

/// Global components turned into the joint frame of their side, minus the components given there.
VecX frame_residuals(const std::array<PlacedFrame, 2>& frames, const std::array<SideWrench, 2>& wrenches) {
  VecX residuals(12);
  for (const Side side : kSides) {
    const SideWrench& wrench = wrenches[index(side)];
    const Mat3 to_C = frames[index(side)].A_joint.transpose();
    residuals.segment<3>(6 * index(side)) = to_C * wrench.in_global.force - wrench.in_C.force;
    residuals.segment<3>(6 * index(side) + 3) = to_C * wrench.in_global.torque - wrench.in_C.torque;
  }
  return residuals;
}

/// F_j + F_i and T_j + T_i + (r_Pi - r_Pj) x F_i.
VecX side_residuals(const std::array<PlacedFrame, 2>& frames, const std::array<SideWrench, 2>& wrenches) {
  const Wrench& on_parent = wrenches[index(Side::parent)].in_global;
  const Wrench& on_child = wrenches[index(Side::child)].in_global;
  const Vec3 gap = frames[index(Side::child)].r_P - frames[index(Side::parent)].r_P;
  VecX residuals(6);
  residuals << on_parent.force + on_child.force, on_parent.torque + on_child.torque + gap.cross(on_child.force);
  return residuals;
}

/// Whether springs or actuators act in joints, or force elements.
bool has_laws(const Model& model) {
  const auto sprung = [](const Joint& joint) { return !joint.springs.empty(); };
  return !model.elements.empty() || std::any_of(model.joints.begin(), model.joints.end(), sprung);
}

/// Both sides' wrenches, global axes, minus what the element's law says.
VecX law_residuals(const ElementLaw& law, const State& state, const ElementWrenches& wrenches) {
  const std::array<Wrench, 2> by_law = law.wrenches(state);
  VecX residuals(12);
  for (const Side side : kSides) {
    residuals.segment<6>(6 * index(side)) = wrenches.on_side(side).in_global.vector() - by_law[index(side)].vector();
  }
  return residuals;
}

/// Of a force: smaller jumps are not looked for.
constexpr double kOfAJump = 1e-9;

/// What round-off changes, and all that a law changes across a jump that is so near: sixteen times as much round-off
/// changes a smooth law by about so many times as much.
VecX with_jumps(const State& state, double length, const VecX& roundoff,
                const std::function<VecX(const State&)>& change_in) {
  constexpr double kNotSmooth = 100.0;
  VecX farther = VecX::Zero(roundoff.size());
  for (const State& moved : about_a_jump(state, length)) farther = farther.cwiseMax(change_in(moved).cwiseAbs());
  return (farther.array() > kNotSmooth * roundoff.array()).select(farther, roundoff);
}

double largest_force(const std::array<SideWrench, 2>& wrenches) {
  return std::max(wrenches[0].in_C.force.norm(), wrenches[1].in_C.force.norm());
}

double largest_torque(const std::array<SideWrench, 2>& wrenches) {
  return std::max(wrenches[0].in_C.torque.norm(), wrenches[1].in_C.torque.norm());
}

/// Scales of a joint or a force element: a force, and the larger of a torque and of the force times a length.
AuditScales scales_of(double force, double torque, double length) {
  AuditScales scales{};
  scales[index(AuditUnit::force)] = force;
  scales[index(AuditUnit::torque)] = std::max(torque, force * length);
  return scales;
}

AuditUnit unit_of_component(int component) { return component < 3 ? AuditUnit::force : AuditUnit::torque; }

/// Six rows, "F_x of total on parent", with what stands behind the component.
void add_components(AuditRule rule, const std::string& of, AuditEntity& entity) {
  for (int c = 0; c < 6; ++c) entity.rows.push_back({rule, kComponentNames[c] + of, unit_of_component(c)});
}

void add_speeds(AuditRule rule, const char* what, const std::vector<bool>& turning, AuditEntity& entity) {
  for (const bool turns : turning) entity.rows.push_back({rule, what, turns ? AuditUnit::torque : AuditUnit::force});
}

}  // namespace

Auditor::Auditor(const Model& model)
    : model_(model), length_(model.length_scale()), has_laws_(has_laws(model)), free_bodies_(model), motions_(model) {
  for (const Body& body : model.bodies) lay_out_body(body);
  for (int k = 0; k < static_cast<int>(model.joints.size()); ++k) lay_out_joint(k);
  for (const ForceElement& element : model.elements) lay_out_element(element);
}

void Auditor::lay_out_body(const Body& body) {
  beams_.push_back(audit_beam(body));
  AuditEntity& entity = bodies_.emplace_back(AuditEntity{body.name, {}, false});
  if (bodies_.size() == 1) return;  // ground
  add_components(AuditRule::free_body, "", entity);
  for (int mode = 1; mode <= body.n_modes(); ++mode) {
    entity.rows.push_back({AuditRule::free_body, "mode " + std::to_string(mode), AuditUnit::own});
  }
}

/// In the order of joint_rows().
void Auditor::lay_out_joint(int k) {
  const Joint& joint = model_.joints[k];
  AuditEntity& entity = joints_.emplace_back(AuditEntity{joint.name, {}, model_.carries_nothing(k)});
  for (const char* side : kOnSide) add_components(AuditRule::workless, std::string(" of reaction") + side, entity);
  add_speeds(AuditRule::workless, "power of the reaction", turning_free_speeds(*joint.type), entity);
  for (const char* wrench : {" of reaction", " of total"}) {
    for (const char* side : kOnSide) add_components(AuditRule::two_frames, std::string(wrench) + side, entity);
  }
  for (const char* wrench : {" of reaction", " of total"}) add_components(AuditRule::both_sides, wrench, entity);
  add_speeds(AuditRule::drivers, "tau", turning_free_speeds(*joint.type), entity);
  add_components(AuditRule::drivers, " of total minus reaction on child", entity);
  for (const char* share : {"motor", "spring", "damper", "tau"}) {
    add_speeds(AuditRule::force_law, share, turning_speeds(*joint.type), entity);
  }
  joint_springs_.push_back(laws_of_springs(joint));
  carried_.push_back(carried_components(*joint.type));
}

/// In the order of add_element().
void Auditor::lay_out_element(const ForceElement& element) {
  element_laws_.emplace_back(element, element_laws_.size());
  AuditEntity& entity = elements_.emplace_back(AuditEntity{element.name, {}, false});
  for (const char* side : kOnSide) add_components(AuditRule::force_law, side, entity);
  for (const char* side : kOnSide) add_components(AuditRule::two_frames, side, entity);
  if (end_of(element, Side::parent) != nullptr) add_components(AuditRule::both_sides, "", entity);
}

void Auditor::add(const State& state, const Evaluation& evaluation, const Redraw& redraw) {
  ++states_;
  OwnRoundOff own(state, redraw);
  moved_ = has_laws_ ? std::optional(within_roundoff(state, length_)) : std::nullopt;
  for (int body = 1; body < static_cast<int>(model_.bodies.size()); ++body) add_body(body, state, evaluation, own);
  for (std::size_t k = 0; k < model_.joints.size(); ++k) add_joint(k, state, evaluation);
  for (std::size_t k = 0; k < model_.elements.size(); ++k) add_element(k, state, evaluation.elements[k]);
  motions_.add(state, evaluation);
}

void Auditor::add_body(int body, const State& state, const Evaluation& evaluation, OwnRoundOff& own) {
  Balance balance = free_bodies_.balance_of(body, state, evaluation);
  if (is_suspicious(balance)) free_bodies_.forget_round_off_of_forces(body, state, evaluation, balance);
  if (is_suspicious(balance)) {
    const auto again = [&](const State& moved, const Evaluation& of_moved) {
      return free_bodies_.balance_of(body, moved, of_moved).rows;
    };
    balance.rows = own.unexplained(balance, again);
  }
  for (Eigen::Index row = 0; AuditRow & one : bodies_[body].rows) {
    one.take(std::abs(balance.rows(row)), balance.scales(row), state.t);
    ++row;
  }
}

OutOfBalance Auditor::out_of_balance(int body, const State& state, const Evaluation& evaluation) const {
  Balance balance = free_bodies_.balance_of(body, state, evaluation);
  const Mat3 to_body = rotation_of(state.bodies[body].p).transpose();
  for (const int first : {0, 3}) balance.rows.segment<3>(first) = (to_body * balance.rows.segment<3>(first)).eval();
  return {std::move(balance.rows), std::move(balance.scales)};
}

void Auditor::add_joint(std::size_t index_of_joint, const State& state, const Evaluation& evaluation) {
  const JointWrenches& wrenches = evaluation.joints[index_of_joint];
  const Joint& joint = model_.joints[index_of_joint];
  const std::vector<LawOfForce>& springs = joint_springs_[index_of_joint];
  const auto frames_in = [&](const State& where) {
    return std::array<PlacedFrame, 2>{place(joint.sides[0], where.bodies[joint.sides[0].body]),
                                      place(joint.sides[1], where.bodies[joint.sides[1].body])};
  };
  const std::array<PlacedFrame, 2> frames = frames_in(state);
  const VecX hint = index_of_joint < state.q.size() ? state.q[index_of_joint] : VecX();
  const VecX coupled = coupled_tau(model_, static_cast<int>(index_of_joint), evaluation.couplings);
  const auto power_in = [&](const std::array<PlacedFrame, 2>& placed) {
    return JointPower(joint, springs, placed, wrenches, coupled, hint, state.t);
  };
  const JointPower power = power_in(frames);
  VecX roundoff = VecX::Zero(static_cast<Eigen::Index>(kActors.size()) * joint.type->n_u());
  if (!joint.springs.empty()) {
    roundoff = power.change_with_last_digits(joint, springs, state.t);
    for (const State& moved : *moved_) roundoff = roundoff.cwiseMax(power.change_of_laws(power_in(frames_in(moved))));
  }
  VecX residuals(joint_rows(*joint.type));
  residuals << workless_residuals(carried_[index_of_joint], wrenches), power.of_reaction(),
      frame_residuals(frames, wrenches.reaction), frame_residuals(frames, wrenches.total),
      side_residuals(frames, wrenches.reaction), side_residuals(frames, wrenches.total), power.beyond_tau(),
      power.outside_coordinates(length_), beyond_roundoff(power.beyond_law(), roundoff);
  double force = std::max(largest_force(wrenches.total), largest_force(wrenches.reaction));
  double torque = std::max(largest_torque(wrenches.total), largest_torque(wrenches.reaction));
  const VecX of_laws = power.sizes_of_laws(joint, springs, state.t);
  const std::vector<bool> turns = turning_speeds(*joint.type);
  for (Eigen::Index c = 0; c < of_laws.size(); ++c) {
    double& size = turns[static_cast<std::size_t>(c)] ? torque : force;
    size = std::max(size, of_laws(c));
  }
  joints_[index_of_joint].take(residuals, scales_of(force, torque, length_), state.t);
}

void Auditor::add_element(std::size_t index_of_element, const State& state, const ElementWrenches& wrenches) {
  const ForceElement& element = model_.elements[index_of_element];
  const Attachment& child = *end_of(element, Side::child);
  const Attachment* parent = end_of(element, Side::parent);
  const PlacedFrame at_child = place(child, state.bodies[child.body]);
  const std::array<PlacedFrame, 2> frames{parent != nullptr ? place(*parent, state.bodies[parent->body]) : at_child,
                                          at_child};
  VecX residuals(parent != nullptr ? 30 : 24);
  const ElementLaw& law = element_laws_[index_of_element];
  const VecX beyond_law = law_residuals(law, state, wrenches);
  VecX roundoff = VecX::Zero(12);
  for (const State& moved : *moved_) {
    roundoff = roundoff.cwiseMax((law_residuals(law, moved, wrenches) - beyond_law).cwiseAbs());
  }
  residuals.head<12>() = beyond_roundoff(beyond_law, roundoff);
  const AuditScales scales = scales_of(largest_force(wrenches.on), largest_torque(wrenches.on), length_);
  if (residuals.head<12>().lpNorm<Eigen::Infinity>() > kOfAJump * scales[index(AuditUnit::force)]) {
    const auto change_in = [&](const State& moved) { return VecX(law_residuals(law, moved, wrenches) - beyond_law); };
    residuals.head<12>() = beyond_roundoff(beyond_law, with_jumps(state, length_, roundoff, change_in));
  }
  residuals.segment<12>(12) = frame_residuals(frames, wrenches.on);
  if (parent != nullptr) residuals.tail<6>() = side_residuals(frames, wrenches.on);
  elements_[index_of_element].take(residuals, scales, state.t);
}

AuditScales Auditor::largest_scales() const {
  AuditScales largest{};
  for (const auto* entities : {&bodies_, &joints_, &elements_, &motions_.joints()}) {
    for (const AuditEntity& entity : *entities) entity.raise(largest);
  }
  return largest;
}

/// A light body on a place that shakes has next to no load, but whoever finds its acceleration from that of the place
/// sums terms as large as all masses would be there.
AuditScales Auditor::largest_terms(const AuditScales& largest) const {
  AuditScales terms = largest;
  double& force = terms[index(AuditUnit::force)];
  double& torque = terms[index(AuditUnit::torque)];
  force = std::max(force, motions_.mass() * largest[index(AuditUnit::acceleration)]);
  torque = std::max(torque, force * length_);
  return terms;
}

AuditReport Auditor::report() const {
  AuditReport report;
  report.states = states_;
  const AuditScales largest = largest_scales();
  const AuditScales terms = largest_terms(largest);
  for (int rule = 0; rule < kAuditRules; ++rule) report.rules[rule].rule = static_cast<AuditRule>(rule);
  // The worst of an entity's own rules, which count for the whole too.
  const auto judge = [&](const AuditEntity& entity, AuditFinding& worst) {
    AuditedPlace& place = report.places.back();
    for (int k = 0; k < kAuditRules; ++k) {
      const AuditFinding finding = entity.worst(static_cast<AuditRule>(k), largest, terms);
      keep_worse(place.rules[k], finding);
      report.rows[k] += entity.count(finding.rule);
      keep_worse(report.rules[k], finding);
      keep_worse(report.worst, finding);
      keep_worse(worst, finding);
    }
  };
  const auto begin = [&](AuditedPlace::Kind kind, std::size_t number) {
    AuditedPlace& place = report.places.emplace_back(AuditedPlace{kind, static_cast<int>(number), {}});
    for (int rule = 0; rule < kAuditRules; ++rule) place.rules[rule].rule = static_cast<AuditRule>(rule);
  };
  for (const AuditEntity& body : bodies_) {
    begin(AuditedPlace::Kind::body, report.bodies.size());
    report.bodies.emplace_back().where = body.name;
    judge(body, report.bodies.back());
    judge(beams_[report.bodies.size() - 1], report.bodies.back());
  }
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    begin(AuditedPlace::Kind::joint, k);
    AuditFinding& joint = report.joints.emplace_back();
    joint.where = joints_[k].name;
    for (const Attachment& side : model_.joints[k].sides) keep_worse(joint, report.bodies[side.body]);
    judge(joints_[k], joint);
    judge(motions_.joints()[k], joint);
  }
  for (const AuditEntity& element : elements_) {
    begin(AuditedPlace::Kind::element, report.elements.size());
    report.elements.emplace_back().where = element.name;
    judge(element, report.elements.back());
  }
  for (const AuditEntity& coupling : motions_.couplings()) {
    begin(AuditedPlace::Kind::coupling, report.couplings.size());
    report.couplings.emplace_back().where = coupling.name;
    judge(coupling, report.couplings.back());
  }
  return report;
}

}  // namespace concord::compare
