#include "cartesian/forces/applied_forces.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "cartesian/bodies/euler_parameters.h"
#include "cartesian/forces/element_forces.h"
#include "cartesian/forces/joint_springs.h"

namespace concord::cartesian {

Wrench opposite(const Wrench& on_child, const Vec3& gap) {
  return {-on_child.force, -(on_child.torque + gap.cross(on_child.force))};
}

namespace {

/// A line spring shorter than this part of the machine's length has a direction of round-off.
constexpr double kShortestLine = 1e-9;

}  // namespace

AppliedForces::AppliedForces(const Model& model, const Layout& layout)
    : model_(model),
      layout_(layout),
      shortest_line_(kShortestLine * model.length_scale()),
      springs_of_joint_(model.joints.size()) {
  for (const ElementIndex e : indices_of(model.elements))
    applied_forces_.add(make_applied_force(pick(model.elements, e), e));
  for (const JointIndex k : indices_of(model.joints)) {
    const Joint& joint = pick(model.joints, k);
    if (!joint.springs.empty()) springs_of_joint_[k] = applied_forces_.add(make_applied_force(joint, k));
  }
  lay_out_events();
}

AppliedForce AppliedForces::make_applied_force(const ForceElement& element, ElementIndex e) const {
  AppliedForce applied;
  applied.owner = OfElement{e};
  for (const Side side : {Side::parent, Side::child}) {
    if (const Attachment* end = end_of(element, side)) make_end(*end, side, applied);
  }
  applied.stop_regimes.resize(1);
  applied.n_event_functions = cartesian::n_event_functions(element);
  return applied;
}

AppliedForce AppliedForces::make_applied_force(const Joint& joint, JointIndex k) const {
  AppliedForce applied;
  applied.owner = OfSprings{k};
  for (const Side side : {Side::parent, Side::child}) make_end(joint.on(side), side, applied);
  applied.stop_regimes.resize(joint.springs.size());
  applied.n_event_functions = cartesian::n_event_functions(joint);
  applied.tau.setZero(joint.type->n_u());
  applied.known_q.setZero(joint.type->n_q());
  for (const JointSpring& spring : joint.springs) {
    applied.spring_turns.push_back(reads_turn(*read_of(*joint.type, spring.word), spring.component));
  }
  return applied;
}

void AppliedForces::make_end(const Attachment& end, Side side, AppliedForce& applied) const {
  applied.ends[index(side)] = &end;
  applied.markers[index(side)] = make_marker(end);
  const VecX none;
  place(end, Vec3::Zero(), Mat3::Identity(), none.head(0), applied.markers[index(side)]);
  if (applied.sits_on_moving_body(side)) applied.forces[index(side)].setZero(layout_.size_Y(body_of(end)));
}

void AppliedForces::lay_out_events() {
  for (const AppliedForceIndex applied : applied_forces_.indices()) {
    event_owners_.insert(event_owners_.end(), static_cast<std::size_t>(applied_forces_[applied].n_event_functions),
                         applied);
  }
  event_values_ = VecX::Zero(static_cast<Eigen::Index>(event_owners_.size()));
}

const ForceElement* AppliedForces::element_of(const AppliedForce& applied) const {
  const auto* owner = std::get_if<OfElement>(&applied.owner);
  return owner != nullptr ? &pick(model_.elements, owner->element) : nullptr;
}

ForceInstant AppliedForces::instant_of(const ForceElement& element, const Mat3& A_child, double t) const {
  return {element.name, t, A_child, shortest_line_, regimes_};
}

void AppliedForces::update(const MovingConstraints& at, double t, const Eigen::Ref<const VecX>& q,
                           const Eigen::Ref<const VecX>& Y) {
  for (const AppliedForceIndex applied : applied_forces_.indices()) update(at, applied, t, q, Y);
}

void AppliedForces::update(const MovingConstraints& at, AppliedForceIndex of, double t, const Eigen::Ref<const VecX>& q,
                           const Eigen::Ref<const VecX>& Y) {
  AppliedForce& applied = applied_forces_[of];
  const std::optional<JointIndex> joint = applied.joint();
  if (joint) {
    exert_springs(pick(model_.joints, *joint), at.joint(*joint), t, regimes_, applied);
  } else {
    place_ends(
        applied, [&](BodyIndex body) -> const Mat3& { return at.rotation(body); }, q, Y);
    const ForceElement& element = *element_of(applied);
    exert(element, instant_of(element, at.rotation(applied.body(Side::child)), t), applied);
  }
  for (const Side side : {Side::parent, Side::child}) {
    if (!applied.sits_on_moving_body(side)) continue;
    const Marker& marker = joint ? at.joint(*joint).marker(side) : applied.markers[index(side)];
    const Wrench& wrench = applied.wrenches[index(side)];
    write_generalized_force(marker, wrench.force, wrench.torque, applied.forces[index(side)]);
  }
}

void AppliedForces::place_end(AppliedForce& applied, Side side, const Mat3& A, const Eigen::Ref<const VecX>& q,
                              const Eigen::Ref<const VecX>& Y) const {
  const Attachment& end = *applied.ends[index(side)];
  const BodyIndex body = applied.body(side);
  Marker& marker = applied.markers[index(side)];
  try {
    place(end, layout_.r(q, body), A, layout_.a(q, body), marker);
  } catch (const LargeRotation& turned) {
    throw LargeRotation(fmt::format("force element '{}'", element_of(applied)->name), turned.angle);
  }
  move(end, A, layout_.v(Y, body), layout_.omega(Y, body), layout_.adot(Y, body), marker);
}

template <class RotationOf>
void AppliedForces::place_ends(AppliedForce& applied, const RotationOf& rotation_of_body,
                               const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y) const {
  for (const Side side : {Side::parent, Side::child}) {
    if (!applied.sits_on_moving_body(side)) continue;
    place_end(applied, side, rotation_of_body(applied.body(side)), q, Y);
  }
  place_relative(applied.parent(), applied.child(), applied.motion);
  move_relative(applied.parent(), applied.child(), applied.motion);
}

const VecX& AppliedForces::event_functions(const PlacedConstraints& near, double t, const Eigen::Ref<const VecX>& q,
                                           const Eigen::Ref<const VecX>& Y) {
  double* next = event_values_.data();
  for (AppliedForce& applied : applied_forces_) {
    if (applied.n_event_functions == 0) continue;
    place_ends(
        applied, [&](BodyIndex body) { return rotation_of(layout_.p(q, body).normalized()); }, q, Y);
    if (const std::optional<JointIndex> joint = applied.joint()) {
      applied.motion.is_beyond_upright = near.joint(*joint).motion.is_beyond_upright;
      next = write_event_functions(pick(model_.joints, *joint), applied.motion, applied, next);
    } else {
      const ForceElement& element = *element_of(applied);
      const Mat3& A_child = near.rotation(applied.body(Side::child));  // for loads, which have no events
      next = write_event_functions(element, instant_of(element, A_child, t), applied, next);
    }
  }
  return event_values_;
}

std::optional<AppliedForceIndex> AppliedForces::departed(const MovingConstraints& at, double t) const {
  for (const AppliedForceIndex k : applied_forces_.indices()) {
    const AppliedForce& applied = applied_forces_[k];
    if (applied.n_event_functions == 0) continue;
    const std::optional<JointIndex> joint = applied.joint();
    const double departure =
        joint ? departure_of(pick(model_.joints, *joint), at.joint(*joint).motion, applied)
              : departure_of(*element_of(applied),
                             instant_of(*element_of(applied), at.rotation(applied.body(Side::child)), t), applied);
    if (departure > kLargestDeparture) return k;
  }
  return std::nullopt;
}

std::string AppliedForces::name_of_regime(AppliedForceIndex applied) const {
  const AppliedForce& of = applied_forces_[applied];
  if (const std::optional<JointIndex> joint = of.joint()) {
    return fmt::format("the stop of joint '{}'", pick(model_.joints, *joint).name);
  }
  const ForceElement& element = *element_of(of);
  return fmt::format("{} '{}'", std::holds_alternative<Tire>(element.what) ? "tire" : "the stop of", element.name);
}

void AppliedForces::add_to(Eigen::Ref<VecX> forces) const {
  for (const AppliedForce& applied : applied_forces_) {
    for (const Side side : {Side::parent, Side::child}) {
      if (!applied.sits_on_moving_body(side)) continue;
      const BodyIndex body = applied.body(side);
      forces.segment(layout_.first_Y(body), layout_.size_Y(body)) += applied.forces[index(side)];
    }
  }
}

double AppliedForces::power(const Eigen::Ref<const VecX>& Y) const {
  double sum = 0.0;
  for (const AppliedForce& applied : applied_forces_) {
    for (const Side side : {Side::parent, Side::child}) {
      if (!applied.sits_on_moving_body(side)) continue;
      const BodyIndex body = applied.body(side);
      sum += applied.forces[index(side)].dot(Y.segment(layout_.first_Y(body), layout_.size_Y(body)));
    }
  }
  return sum;
}

const AppliedForce* AppliedForces::springs_of(JointIndex k) const {
  return springs_of_joint_[k] ? &applied_forces_[*springs_of_joint_[k]] : nullptr;
}

ElementWrenches AppliedForces::element(ElementIndex e) const {
  const AppliedForce& applied = applied_forces_[AppliedForceIndex(e.value)];  // elements come first
  ElementWrenches wrenches;
  for (const Side side : {Side::parent, Side::child}) {
    if (applied.ends[index(side)] == nullptr) continue;
    const Mat3& A_joint = applied.markers[index(side)].A_joint;
    const Wrench& in_global = applied.wrenches[index(side)];
    wrenches.on[index(side)] = {{A_joint.transpose() * in_global.force, A_joint.transpose() * in_global.torque},
                                in_global};
  }
  return wrenches;
}

template <class Visit>
void AppliedForces::each_line_spring(const Visit& visit) const {
  for (const AppliedForce& applied : applied_forces_) {
    const ForceElement* element = element_of(applied);
    const auto* spring = element != nullptr ? std::get_if<LineSpring>(&element->what) : nullptr;
    if (spring != nullptr) visit(element->name, *spring, applied);
  }
}

std::vector<SpringLine> AppliedForces::spring_lines(double t) const {
  std::vector<SpringLine> lines;
  each_line_spring([&](const std::string& name, const LineSpring& spring, const AppliedForce& applied) {
    lines.push_back(line_of(spring, name, applied, t));
  });
  return lines;
}

double AppliedForces::fastest_line_rate() const {
  double fastest = 0.0;
  each_line_spring([&](const std::string& /*name*/, const LineSpring& /*spring*/, const AppliedForce& applied) {
    const double speed = (applied.child().velocity - applied.parent().velocity).norm();
    fastest = std::max(fastest, speed / (applied.child().point - applied.parent().point).norm());
  });
  return fastest;
}

RegimesOfAll AppliedForces::regimes() const {
  RegimesOfAll all;
  for (const AppliedForce& applied : applied_forces_) {
    all.of_tires.push_back(applied.regime);
    all.of_stops.push_back(applied.stop_regimes);
  }
  return all;
}

void AppliedForces::keep_regimes(const RegimesOfAll& regimes) {
  std::size_t k = 0;
  for (AppliedForce& applied : applied_forces_) {
    applied.regime = regimes.of_tires[k];
    applied.stop_regimes = regimes.of_stops[k];
    ++k;
  }
  freeze_regimes(true);
}

void AppliedForces::count_turns_from(const std::vector<VecX>& q) {
  for (AppliedForce& applied : applied_forces_) {
    if (const std::optional<JointIndex> joint = applied.joint()) applied.known_q = q[joint->value];
  }
}

template <class Visit>
void AppliedForces::each_turn_spring(const Visit& visit) const {
  for (const ElementIndex e : indices_of(model_.elements)) {
    // Elements come first.
    if (std::holds_alternative<TurnSpring>(pick(model_.elements, e).what)) visit(e, AppliedForceIndex(e.value));
  }
}

void AppliedForces::count_spring_turns_from(const State& state) {
  each_turn_spring([&](ElementIndex e, AppliedForceIndex spring) {
    applied_forces_[spring].known_angle = state.known_angle(static_cast<std::size_t>(e.value));
  });
}

void AppliedForces::follow_spring_turns() {
  each_turn_spring([&](ElementIndex /*e*/, AppliedForceIndex spring) {
    applied_forces_[spring].known_angle = angle_of_turn_spring(applied_forces_[spring]);
  });
}

std::vector<double> AppliedForces::spring_angles(const MovingConstraints& at, const Eigen::Ref<const VecX>& q,
                                                 const Eigen::Ref<const VecX>& Y) const {
  std::vector<double> angles(model_.elements.size(), 0.0);
  each_turn_spring([&](ElementIndex e, AppliedForceIndex spring) {
    AppliedForce placed = applied_forces_[spring];
    place_ends(
        placed, [&](BodyIndex body) -> const Mat3& { return at.rotation(body); }, q, Y);
    angles[static_cast<std::size_t>(e.value)] = angle_of_turn_spring(placed);
  });
  return angles;
}

void AppliedForces::count_turns_and_hold_regimes_as(const AppliedForces& other) {
  for (const AppliedForceIndex applied : applied_forces_.indices()) {
    const AppliedForce& known = other.applied_forces_[applied];
    applied_forces_[applied].known_q = known.known_q;
    applied_forces_[applied].known_angle = known.known_angle;
    applied_forces_[applied].regime = known.regime;
    applied_forces_[applied].stop_regimes = known.stop_regimes;
  }
  regimes_ = other.regimes_;
}

}  // namespace concord::cartesian
