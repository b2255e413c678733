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
  for (std::size_t e = 0; e < model.elements.size(); ++e) {
    actors_.push_back(make_actor(model.elements[e], static_cast<int>(e)));
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    if (model.joints[k].springs.empty()) continue;
    springs_of_joint_[k] = static_cast<int>(actors_.size());
    actors_.push_back(make_actor(model.joints[k], static_cast<int>(k)));
  }
  lay_out_events();
}

Actor AppliedForces::make_actor(const ForceElement& element, int e) const {
  Actor actor;
  actor.owner = OfElement{e};
  for (const Side side : {Side::parent, Side::child}) {
    if (const Attachment* end = end_of(element, side)) make_end(*end, side, actor);
  }
  actor.stop_regimes.resize(1);
  actor.n_event_functions = cartesian::n_event_functions(element);
  return actor;
}

Actor AppliedForces::make_actor(const Joint& joint, int k) const {
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
  if (actor.sits_on_moving_body(side)) actor.forces[index(side)].setZero(layout_.size_Y(end.body));
}

void AppliedForces::lay_out_events() {
  for (std::size_t k = 0; k < actors_.size(); ++k) {
    event_owners_.insert(event_owners_.end(), static_cast<std::size_t>(actors_[k].n_event_functions),
                         static_cast<int>(k));
  }
  event_values_ = VecX::Zero(static_cast<Eigen::Index>(event_owners_.size()));
}

const ForceElement* AppliedForces::element_of(const Actor& actor) const {
  const auto* owner = std::get_if<OfElement>(&actor.owner);
  return owner != nullptr ? &model_.elements[owner->element] : nullptr;
}

ForceInstant AppliedForces::instant_of(const ForceElement& element, const Mat3& A_child, double t) const {
  return {element.name, t, A_child, shortest_line_, regimes_};
}

void AppliedForces::update(const Constraints& at, double t, const Eigen::Ref<const VecX>& q,
                           const Eigen::Ref<const VecX>& Y) {
  for (std::size_t k = 0; k < actors_.size(); ++k) update(at, static_cast<int>(k), t, q, Y);
}

void AppliedForces::update(const Constraints& at, int of, double t, const Eigen::Ref<const VecX>& q,
                           const Eigen::Ref<const VecX>& Y) {
  Actor& actor = actors_[of];
  const std::optional<int> joint = actor.joint();
  if (joint) {
    exert_springs(model_.joints[*joint], at.joint(*joint), t, regimes_, actor);
  } else {
    place_ends(
        actor, [&](int body) -> const Mat3& { return at.rotation(body); }, q, Y);
    const ForceElement& element = *element_of(actor);
    exert(element, instant_of(element, at.rotation(actor.ends[index(Side::child)]->body), t), actor);
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
  Marker& marker = actor.markers[index(side)];
  try {
    place(end, layout_.r(q, end.body), A, layout_.a(q, end.body), marker);
  } catch (const LargeRotation& turned) {
    throw LargeRotation(fmt::format("force element '{}'", element_of(actor)->name), turned.angle);
  }
  move(end, A, layout_.v(Y, end.body), layout_.omega(Y, end.body), layout_.adot(Y, end.body), marker);
}

template <class RotationOf>
void AppliedForces::place_ends(Actor& actor, const RotationOf& rotation_of_body, const Eigen::Ref<const VecX>& q,
                               const Eigen::Ref<const VecX>& Y) const {
  for (const Side side : {Side::parent, Side::child}) {
    if (!actor.sits_on_moving_body(side)) continue;
    place_end(actor, side, rotation_of_body(actor.ends[index(side)]->body), q, Y);
  }
  place_relative(actor.parent(), actor.child(), actor.motion);
  move_relative(actor.parent(), actor.child(), actor.motion);
}

const VecX& AppliedForces::event_functions(const Constraints& near, double t, const Eigen::Ref<const VecX>& q,
                                           const Eigen::Ref<const VecX>& Y) {
  double* next = event_values_.data();
  for (Actor& actor : actors_) {
    if (actor.n_event_functions == 0) continue;
    place_ends(
        actor, [&](int body) { return rotation_of(layout_.p(q, body).normalized()); }, q, Y);
    if (const std::optional<int> joint = actor.joint()) {
      actor.motion.is_beyond_upright = near.joint(*joint).motion.is_beyond_upright;
      next = write_event_functions(model_.joints[*joint], actor.motion, actor, next);
    } else {
      const ForceElement& element = *element_of(actor);
      const Mat3& A_child = near.rotation(actor.ends[index(Side::child)]->body);  // for loads, which have no events
      next = write_event_functions(element, instant_of(element, A_child, t), actor, next);
    }
  }
  return event_values_;
}

std::string AppliedForces::name_of_regime(int actor) const {
  const Actor& of = actors_[actor];
  if (const std::optional<int> joint = of.joint()) {
    return fmt::format("the stop of joint '{}'", model_.joints[*joint].name);
  }
  const ForceElement& element = *element_of(of);
  return fmt::format("{} '{}'", std::holds_alternative<Tire>(element.what) ? "tire" : "the stop of", element.name);
}

void AppliedForces::add_to(Eigen::Ref<VecX> forces) const {
  for (const Actor& actor : actors_) {
    for (const Side side : {Side::parent, Side::child}) {
      if (!actor.sits_on_moving_body(side)) continue;
      const int body = actor.ends[index(side)]->body;
      forces.segment(layout_.first_Y(body), layout_.size_Y(body)) += actor.forces[index(side)];
    }
  }
}

double AppliedForces::power(const Eigen::Ref<const VecX>& Y) const {
  double sum = 0.0;
  for (const Actor& actor : actors_) {
    for (const Side side : {Side::parent, Side::child}) {
      if (!actor.sits_on_moving_body(side)) continue;
      const int body = actor.ends[index(side)]->body;
      sum += actor.forces[index(side)].dot(Y.segment(layout_.first_Y(body), layout_.size_Y(body)));
    }
  }
  return sum;
}

const Actor* AppliedForces::springs_of(int k) const {
  return springs_of_joint_[k] ? &actors_[*springs_of_joint_[k]] : nullptr;
}

ElementWrenches AppliedForces::element(int e) const {
  const Actor& actor = actors_[e];
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

void AppliedForces::count_turns_from(const std::vector<VecX>& q) {
  for (Actor& actor : actors_) {
    if (const std::optional<int> joint = actor.joint()) actor.known_q = q[*joint];
  }
}

void AppliedForces::count_turns_and_hold_regimes_as(const AppliedForces& other) {
  for (std::size_t k = 0; k < actors_.size(); ++k) {
    const Actor& known = other.actors_[k];
    actors_[k].known_q = known.known_q;
    actors_[k].regime = known.regime;
    actors_[k].stop_regimes = known.stop_regimes;
  }
  regimes_ = other.regimes_;
}

}  // namespace concord::cartesian
