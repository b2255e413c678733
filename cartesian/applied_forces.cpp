#include "cartesian/applied_forces.h"

#include <fmt/format.h>

#include <utility>

#include "cartesian/element_forces.h"
#include "cartesian/euler_parameters.h"
#include "cartesian/joint_springs.h"

namespace concord::cartesian {

namespace {

/// A line spring shorter than this part of the machine's length has a direction of round-off.
constexpr double kShortestLine = 1e-9;

}  // namespace

AppliedForces::AppliedForces(const Model& model, const Layout& layout)
    : model_(model),
      layout_(layout),
      shortest_line_(kShortestLine * model.length_scale()),
      springs_of_joint_(model.joints.size()) {
  for (const ElementIndex e : indices_of(model.elements)) actors_.add(make_actor(pick(model.elements, e), e));
  for (const JointIndex k : indices_of(model.joints)) {
    const Joint& joint = pick(model.joints, k);
    if (!joint.springs.empty()) springs_of_joint_[k] = actors_.add(make_actor(joint, k));
  }
  lay_out_events();
}

Actor AppliedForces::make_actor(const ForceElement& element, ElementIndex e) const {
  Actor actor;
  actor.owner = OfElement{e};
  for (const Side side : {Side::parent, Side::child}) {
    if (const Attachment* end = end_of(element, side)) make_end(*end, side, actor);
  }
  actor.stop_regimes.resize(1);
  actor.n_event_functions = cartesian::n_event_functions(element);
  return actor;
}

Actor AppliedForces::make_actor(const Joint& joint, JointIndex k) const {
  Actor actor;
  actor.owner = OfSprings{k};
  for (const Side side : {Side::parent, Side::child}) make_end(joint.on(side), side, actor);
  actor.stop_regimes.resize(joint.springs.size());
  actor.n_event_functions = cartesian::n_event_functions(joint);
  actor.tau.setZero(joint.type->n_u());
  actor.known_q.setZero(joint.type->n_q());
  for (const JointSpring& spring : joint.springs) {
    actor.spring_turns.push_back(reads_turn(*read_of(*joint.type, spring.word), spring.component));
  }
  return actor;
}

void AppliedForces::make_end(const Attachment& end, Side side, Actor& actor) const {
  actor.ends[index(side)] = &end;
  actor.markers[index(side)] = make_marker(end);
  const VecX none;
  place(end, Vec3::Zero(), Mat3::Identity(), none.head(0), actor.markers[index(side)]);
  if (actor.sits_on_moving_body(side)) actor.forces[index(side)].setZero(layout_.size_Y(body_of(end)));
}

void AppliedForces::lay_out_events() {
  for (const ActorIndex actor : actors_.indices()) {
    event_owners_.insert(event_owners_.end(), static_cast<std::size_t>(actors_[actor].n_event_functions), actor);
  }
  event_values_ = VecX::Zero(static_cast<Eigen::Index>(event_owners_.size()));
}

const ForceElement* AppliedForces::element_of(const Actor& actor) const {
  const auto* owner = std::get_if<OfElement>(&actor.owner);
  return owner != nullptr ? &pick(model_.elements, owner->element) : nullptr;
}

ForceInstant AppliedForces::instant_of(const ForceElement& element, const Mat3& A_child, double t) const {
  return {element.name, t, A_child, shortest_line_, regimes_};
}

void AppliedForces::update(const MovingConstraints& at, double t, const Eigen::Ref<const VecX>& q,
                           const Eigen::Ref<const VecX>& Y) {
  for (const ActorIndex actor : actors_.indices()) update(at, actor, t, q, Y);
}

void AppliedForces::update(const MovingConstraints& at, ActorIndex of, double t, const Eigen::Ref<const VecX>& q,
                           const Eigen::Ref<const VecX>& Y) {
  Actor& actor = actors_[of];
  const std::optional<JointIndex> joint = actor.joint();
  if (joint) {
    exert_springs(pick(model_.joints, *joint), at.joint(*joint), t, regimes_, actor);
  } else {
    place_ends(
        actor, [&](BodyIndex body) -> const Mat3& { return at.rotation(body); }, q, Y);
    const ForceElement& element = *element_of(actor);
    exert(element, instant_of(element, at.rotation(actor.body(Side::child)), t), actor);
  }
  for (const Side side : {Side::parent, Side::child}) {
    if (!actor.sits_on_moving_body(side)) continue;
    const Marker& marker = joint ? at.joint(*joint).marker(side) : actor.markers[index(side)];
    const Wrench& wrench = actor.wrenches[index(side)];
    write_generalized_force(marker, wrench.force, wrench.torque, actor.forces[index(side)]);
  }
}

void AppliedForces::place_end(Actor& actor, Side side, const Mat3& A, const Eigen::Ref<const VecX>& q,
                              const Eigen::Ref<const VecX>& Y) const {
  const Attachment& end = *actor.ends[index(side)];
  const BodyIndex body = actor.body(side);
  Marker& marker = actor.markers[index(side)];
  try {
    place(end, layout_.r(q, body), A, layout_.a(q, body), marker);
  } catch (const LargeRotation& turned) {
    throw LargeRotation(fmt::format("force element '{}'", element_of(actor)->name), turned.angle);
  }
  move(end, A, layout_.v(Y, body), layout_.omega(Y, body), layout_.adot(Y, body), marker);
}

template <class RotationOf>
void AppliedForces::place_ends(Actor& actor, const RotationOf& rotation_of_body, const Eigen::Ref<const VecX>& q,
                               const Eigen::Ref<const VecX>& Y) const {
  for (const Side side : {Side::parent, Side::child}) {
    if (!actor.sits_on_moving_body(side)) continue;
    place_end(actor, side, rotation_of_body(actor.body(side)), q, Y);
  }
  place_relative(actor.parent(), actor.child(), actor.motion);
  move_relative(actor.parent(), actor.child(), actor.motion);
}

const VecX& AppliedForces::event_functions(const PlacedConstraints& near, double t, const Eigen::Ref<const VecX>& q,
                                           const Eigen::Ref<const VecX>& Y) {
  double* next = event_values_.data();
  for (Actor& actor : actors_) {
    if (actor.n_event_functions == 0) continue;
    place_ends(
        actor, [&](BodyIndex body) { return rotation_of(layout_.p(q, body).normalized()); }, q, Y);
    if (const std::optional<JointIndex> joint = actor.joint()) {
      actor.motion.is_beyond_upright = near.joint(*joint).motion.is_beyond_upright;
      next = write_event_functions(pick(model_.joints, *joint), actor.motion, actor, next);
    } else {
      const ForceElement& element = *element_of(actor);
      const Mat3& A_child = near.rotation(actor.body(Side::child));  // for loads, which have no events
      next = write_event_functions(element, instant_of(element, A_child, t), actor, next);
    }
  }
  return event_values_;
}

std::string AppliedForces::name_of_regime(ActorIndex actor) const {
  const Actor& of = actors_[actor];
  if (const std::optional<JointIndex> joint = of.joint()) {
    return fmt::format("the stop of joint '{}'", pick(model_.joints, *joint).name);
  }
  const ForceElement& element = *element_of(of);
  return fmt::format("{} '{}'", std::holds_alternative<Tire>(element.what) ? "tire" : "the stop of", element.name);
}

void AppliedForces::add_to(Eigen::Ref<VecX> forces) const {
  for (const Actor& actor : actors_) {
    for (const Side side : {Side::parent, Side::child}) {
      if (!actor.sits_on_moving_body(side)) continue;
      const BodyIndex body = actor.body(side);
      forces.segment(layout_.first_Y(body), layout_.size_Y(body)) += actor.forces[index(side)];
    }
  }
}

double AppliedForces::power(const Eigen::Ref<const VecX>& Y) const {
  double sum = 0.0;
  for (const Actor& actor : actors_) {
    for (const Side side : {Side::parent, Side::child}) {
      if (!actor.sits_on_moving_body(side)) continue;
      const BodyIndex body = actor.body(side);
      sum += actor.forces[index(side)].dot(Y.segment(layout_.first_Y(body), layout_.size_Y(body)));
    }
  }
  return sum;
}

const Actor* AppliedForces::springs_of(JointIndex k) const {
  return springs_of_joint_[k] ? &actors_[*springs_of_joint_[k]] : nullptr;
}

ElementWrenches AppliedForces::element(ElementIndex e) const {
  const Actor& actor = actors_[ActorIndex(e.value)];  // elements come first
  ElementWrenches wrenches;
  for (const Side side : {Side::parent, Side::child}) {
    if (actor.ends[index(side)] == nullptr) continue;
    const Mat3& A_joint = actor.markers[index(side)].A_joint;
    const Wrench& in_global = actor.wrenches[index(side)];
    wrenches.on[index(side)] = {{A_joint.transpose() * in_global.force, A_joint.transpose() * in_global.torque},
                                in_global};
  }
  return wrenches;
}

std::vector<SpringLine> AppliedForces::spring_lines(double t) const {
  std::vector<SpringLine> lines;
  for (const Actor& actor : actors_) {
    const ForceElement* element = element_of(actor);
    const auto* spring = element != nullptr ? std::get_if<LineSpring>(&element->what) : nullptr;
    if (spring != nullptr) lines.push_back(line_of(*spring, element->name, actor, t));
  }
  return lines;
}

RegimesOfAll AppliedForces::regimes() const {
  RegimesOfAll all;
  for (const Actor& actor : actors_) {
    all.of_tires.push_back(actor.regime);
    all.of_stops.push_back(actor.stop_regimes);
  }
  return all;
}

void AppliedForces::keep_regimes(const RegimesOfAll& regimes) {
  std::size_t k = 0;
  for (Actor& actor : actors_) {
    actor.regime = regimes.of_tires[k];
    actor.stop_regimes = regimes.of_stops[k];
    ++k;
  }
  freeze_regimes(true);
}

void AppliedForces::count_turns_from(const std::vector<VecX>& q) {
  for (Actor& actor : actors_) {
    if (const std::optional<JointIndex> joint = actor.joint()) actor.known_q = q[joint->value];
  }
}

void AppliedForces::count_turns_and_hold_regimes_as(const AppliedForces& other) {
  for (const ActorIndex actor : actors_.indices()) {
    const Actor& known = other.actors_[actor];
    actors_[actor].known_q = known.known_q;
    actors_[actor].regime = known.regime;
    actors_[actor].stop_regimes = known.stop_regimes;
  }
  regimes_ = other.regimes_;
}

}  // namespace concord::cartesian
