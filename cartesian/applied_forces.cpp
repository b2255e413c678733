#include "cartesian/applied_forces.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "cartesian/euler_parameters.h"
#include "common/error.h"
#include "common/rotation.h"

namespace concord::cartesian {

namespace {

/// The opposite wrench on the parent at P_j, `gap` = r_Pi - r_Pj.
Wrench opposite(const Wrench& on_child, const Vec3& gap) {
  return {-on_child.force, -(on_child.torque + gap.cross(on_child.force))};
}

/// A line spring shorter than this part of the machine's length has a direction of round-off.
constexpr double kShortestLine = 1e-9;

/// Bushings and turn springs are refused beyond it: their angles jump at half a turn.
constexpr double kLargestAngle = 175.0 * EIGEN_PI / 180.0;

/// theta = log(R). Throws SolverError beyond 175 deg.
Vec3 rotation_vector(const Mat3& R, const std::string& name, double t) {
  const Eigen::AngleAxisd turn(R);
  if (!(turn.angle() <= kLargestAngle)) {
    throw SolverError(fmt::format(
        "cartesian: at t = {:.6g} s bushing '{}' is turned by {:.1f} deg, allowed are 175 deg: it is no joint", t, name,
        turn.angle() * 180.0 / EIGEN_PI));
  }
  return turn.angle() * turn.axis();
}

/// J^-T of the rotation vector: 1 + theta~ / 2 + c theta~^2, c = (1 - (t/2) cot(t/2)) / t^2 (C36).
Mat3 inverse_transposed_tangent(const Vec3& theta) {
  const double t_squared = theta.squaredNorm();
  const double half = 0.5 * std::sqrt(t_squared);
  const double c = t_squared < 1e-2 ? 1.0 / 12.0 + t_squared / 720.0 + t_squared * t_squared / 30240.0 +
                                          t_squared * t_squared * t_squared / 1209600.0
                                    : (1.0 - half / std::tan(half)) / t_squared;
  const Mat3 theta_skew = skew(theta);
  return Mat3::Identity() + 0.5 * theta_skew + c * theta_skew * theta_skew;
}

/// A tire above the tangent plane of its road: unit vectors, the centre's distance from the plane, and the contact.
struct TireOnRoad {
  Vec3 normal;
  Vec3 forward;
  Vec3 sideways;
  double distance;
  TireContact contact;
};

/// Throws SolverError where the spin axis is normal to the road (S36), (S37), (C37).
TireOnRoad place_on_road(const Tire& tire, int stretch, const Marker& wheel, const std::string& name, double t) {
  const Vec3& c = wheel.point;
  const Vec3& v = wheel.velocity;
  const RoadHeight road = evaluate(*tire.road, stretch, c.x());
  const double n_z = 1.0 / std::sqrt(1.0 + road.slope * road.slope);
  const double n_z_rate = -road.slope * road.curvature * v.x() * n_z * n_z * n_z;
  const double rise = c.z() - road.h;
  const double distance_rate = (v.z() - road.slope * v.x()) * n_z + rise * n_z_rate;
  TireOnRoad at;
  at.normal = Vec3(-road.slope * n_z, 0.0, n_z);
  at.distance = rise * n_z;
  const Vec3 across = wheel.A_joint.col(1).cross(at.normal);
  if (!(across.norm() > 1e-6)) {
    throw SolverError(fmt::format(
        "cartesian: at t = {:.6g} s tire '{}' has no forward direction: its spin axis stands upright on the road", t,
        name));
  }
  at.forward = across.normalized();
  at.sideways = at.normal.cross(at.forward);
  const Vec3 slip = v - at.distance * wheel.angular_velocity.cross(at.normal);
  at.contact = {.x = c.x(),
                .delta = tire.radius - at.distance,
                .deltadot = -distance_rate,
                .V_x = v.dot(at.forward),
                .V_y = v.dot(at.sideways),
                .s_x = slip.dot(at.forward)};
  return at;
}

/// What a turn spring takes for its angle.
const joints::Read kSpringAngle = joints::TurnOfChildAxis{.about = Axis::z, .of_child_axis = Axis::x};

/// Writes the wrenches of one element on its ends; placed and moved before.
struct WrenchWriter {
  Actor& actor;
  const std::string& name;
  double t;
  const Mat3& A_body;  // of the child
  bool sets_regimes;   // tires and stops take the regime that they are in by themselves
  double shortest;     // line spring that has a direction

  void operator()(const Load& load) const {  // (S32)
    const Mat3 axes = load.axes == LoadAxes::global ? Mat3(Mat3::Identity())
                      : load.axes == LoadAxes::body ? A_body
                                                    : child().A_joint;
    const double size = evaluate(load.law, t).f;
    on_child() = {size * (axes * load.force), size * (axes * load.torque)};
  }

  void operator()(const LineSpring& spring) const {  // (S33)
    const Vec3 line = child().point - parent().point;
    const double length = line.norm();
    if (!(length > shortest)) {
      throw SolverError(fmt::format(
          "cartesian: at t = {:.6g} s the ends of line spring '{}' meet: its force has no direction there", t, name));
    }
    const Vec3 along = line / length;
    const double rate = along.dot(child().velocity - parent().velocity);
    const double tension = resistance(spring.law, length, rate) + evaluate_actuator(spring.law, t);
    on_child() = {-tension * along, Vec3::Zero()};
    on_parent() = {tension * along, Vec3::Zero()};
  }

  void operator()(const TurnSpring& spring) const {  // (S34)
    if (!(actor.motion.R.col(0).head<2>().norm() > 1e-6)) {
      throw SolverError(
          fmt::format("cartesian: at t = {:.6g} s turn spring '{}' has no angle: the child's x axis points along the "
                      "parent's z: turn the frames of its ends",
                      t, name));
    }
    const ConstraintRow angle = evaluate_read(kSpringAngle, 0, actor.motion);
    if (!(std::abs(angle.value) <= kLargestAngle)) {
      throw SolverError(
          fmt::format("cartesian: at t = {:.6g} s turn spring '{}' is turned by {:.1f} deg, allowed are 175 deg: let a "
                      "spring of a joint count turns instead",
                      t, name, angle.value * 180.0 / EIGEN_PI));
    }
    const double rate = rate_of(angle, actor.motion);
    const double torque = resistance(spring.law, angle.value, rate) + evaluate_actuator(spring.law, t);
    const Vec3 couple = parent().A_joint * (-torque * angle.over_rho);
    on_child() = {Vec3::Zero(), couple};
    on_parent() = {Vec3::Zero(), -couple};
  }

  void operator()(const Bushing& bushing) const {  // (S35)
    const Vec3 theta = rotation_vector(actor.motion.R, name, t);
    Vec6 displacement;
    displacement << actor.motion.d, theta;
    Vec6 speed;
    speed << actor.motion.ddot, actor.motion.omega;
    Vec6 elastic = bushing.stiffness * displacement - bushing.preload;
    elastic.tail<3>() = inverse_transposed_tangent(theta) * elastic.tail<3>();
    const Vec6 in_C = -elastic - bushing.damping * speed;
    on_child() = {parent().A_joint * in_C.head<3>(), parent().A_joint * in_C.tail<3>()};
    on_parent() = opposite(on_child(), child().point - parent().point);
  }

  void operator()(const Tire& tire) const {  // (S39)
    if (sets_regimes) actor.regime.stretch = stretch_at(*tire.road, child().point.x());
    const TireOnRoad at = place_on_road(tire, actor.regime.stretch, child(), name, t);
    if (sets_regimes) actor.regime = regime_at(tire, at.contact);
    const TireForces forces = evaluate(tire, actor.regime, at.contact);
    const Vec3 force = forces.N * at.normal + forces.F_x * at.forward + forces.F_y * at.sideways;
    on_child() = {force, -at.distance * at.normal.cross(force)};
  }

 private:
  [[nodiscard]] double resistance(const ForceLaw& law, double x, double rate) const {
    LawRegime& regime = actor.stop_regimes.front();
    if (sets_regimes) regime = regime_at(law, x, rate);
    return evaluate_resistance(law, regime, x, rate).force;
  }
  [[nodiscard]] const Marker& child() const { return actor.markers[index(Side::child)]; }
  [[nodiscard]] const Marker& parent() const { return actor.markers[index(Side::parent)]; }
  [[nodiscard]] Wrench& on_child() const { return actor.wrenches[index(Side::child)]; }
  [[nodiscard]] Wrench& on_parent() const { return actor.wrenches[index(Side::parent)]; }
};

}  // namespace

AppliedForces::AppliedForces(const Model& model, const Layout& layout, const Constraints& constraints)
    : model_(model),
      layout_(layout),
      constraints_(constraints),
      shortest_line_(kShortestLine * model.length_scale()),
      springs_of_joint_(model.joints.size()) {
  const auto allocate = [&](Actor& actor) {
    for (const Side side : {Side::parent, Side::child}) {
      if (!actor.sits_on_moving_body(side)) continue;
      actor.forces[index(side)].setZero(layout.size_Y(actor.ends[index(side)]->body));
    }
  };
  for (std::size_t e = 0; e < model.elements.size(); ++e) {
    Actor actor;
    actor.owner = OfElement{static_cast<int>(e)};
    for (const Side side : {Side::parent, Side::child}) {
      const Attachment* end = end_of(model.elements[e], side);
      actor.ends[index(side)] = end;
      if (end == nullptr) continue;
      actor.markers[index(side)] = make_marker(*end);
      const VecX none;
      place(*end, Vec3::Zero(), Mat3::Identity(), none.head(0), actor.markers[index(side)]);
    }
    actor.stop_regimes.resize(1);
    allocate(actor);
    actors_.push_back(std::move(actor));
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    if (joint.springs.empty()) continue;
    springs_of_joint_[k] = static_cast<int>(actors_.size());
    Actor actor;
    actor.owner = OfSprings{static_cast<int>(k)};
    actor.ends = {&joint.on(Side::parent), &joint.on(Side::child)};
    for (const Side side : {Side::parent, Side::child}) {
      actor.markers[index(side)] = make_marker(joint.on(side));
      const VecX none;
      place(joint.on(side), Vec3::Zero(), Mat3::Identity(), none.head(0), actor.markers[index(side)]);
    }
    actor.stop_regimes.resize(joint.springs.size());
    actor.tau.setZero(joint.type->n_u());
    actor.known_q.setZero(joint.type->n_q());
    for (const JointSpring& spring : joint.springs) {
      actor.spring_turns.push_back(reads_turn(*read_of(*joint.type, spring.word), spring.component));
    }
    allocate(actor);
    actors_.push_back(std::move(actor));
  }
  lay_out_events();
}

const ForceElement* AppliedForces::element_of(const Actor& actor) const {
  const auto* owner = std::get_if<OfElement>(&actor.owner);
  return owner != nullptr ? &model_.elements[owner->element] : nullptr;
}

void AppliedForces::update(double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y) {
  for (Actor& actor : actors_) update(actor, t, q, Y);
}

void AppliedForces::update(Actor& actor, double t, const Eigen::Ref<const VecX>& q,
                           const Eigen::Ref<const VecX>& Y) const {
  if (const ForceElement* element = element_of(actor)) {
    place_ends(actor, q, Y);
    const Mat3& A_body = constraints_.rotation(actor.ends[index(Side::child)]->body);
    std::visit(WrenchWriter{actor, element->name, t, A_body, !regimes_are_frozen_, shortest_line_}, element->what);
  } else {
    apply_springs(actor, t);
  }
  const std::optional<int> joint = actor.joint();
  for (const Side side : {Side::parent, Side::child}) {
    if (!actor.sits_on_moving_body(side)) continue;
    const Marker& marker = joint ? constraints_.joint(*joint).marker(side) : actor.markers[index(side)];
    const Wrench& wrench = actor.wrenches[index(side)];
    write_generalized_force(marker, wrench.force, wrench.torque, actor.forces[index(side)]);
  }
}

void AppliedForces::place_end(Actor& actor, Side side, const Mat3& A, const Eigen::Ref<const VecX>& q,
                              const Eigen::Ref<const VecX>& Y) const {
  const Attachment& end = *actor.ends[index(side)];
  Marker& marker = actor.markers[index(side)];
  place(end, layout_.r(q, end.body), A, layout_.a(q, end.body), marker);
  move(end, A, layout_.v(Y, end.body), layout_.omega(Y, end.body), layout_.adot(Y, end.body), marker);
}

void AppliedForces::place_ends(Actor& actor, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y) const {
  for (const Side side : {Side::parent, Side::child}) {
    if (actor.sits_on_moving_body(side)) {
      place_end(actor, side, constraints_.rotation(actor.ends[index(side)]->body), q, Y);
    }
  }
  const Marker& parent = actor.markers[index(Side::parent)];
  const Marker& child = actor.markers[index(Side::child)];
  place_relative(parent, child, actor.motion);
  move_relative(parent, child, actor.motion);
}

/// tau = actuator - resistance for each sprung coordinate; the coordinate wrench acts like the joint's own (C38).
void AppliedForces::apply_springs(Actor& actor, double t) const {
  const int of_joint = *actor.joint();
  const Joint& stated = model_.joints[of_joint];
  const JointEquations& joint = constraints_.joint(of_joint);
  actor.tau.setZero();
  for (std::size_t k = 0; k < stated.springs.size(); ++k) {
    const JointSpring& spring = stated.springs[k];
    const joints::Read& read = *read_of(*stated.type, spring.word);
    const ConstraintRow row = evaluate_read(read, spring.component, joint.motion);
    const double known = actor.known_q(first_q(*stated.type, spring.word) + spring.component);
    const double x = value_near(actor.spring_turns[k], row, known);
    const double rate = rate_of(row, joint.motion);
    if (!regimes_are_frozen_) actor.stop_regimes[k] = regime_at(spring.law, x, rate);
    actor.tau(first_u(*stated.type, spring.word) + spring.component) +=
        evaluate_actuator(spring.law, t) - evaluate_resistance(spring.law, actor.stop_regimes[k], x, rate).force;
  }
  const Vec6 in_C = coordinate_wrench(*stated.type, joint.motion, actor.tau);
  const Mat3& A_joint = joint.marker(Side::parent).A_joint;
  Wrench& on_child = actor.wrenches[index(Side::child)];
  on_child = {A_joint * in_C.head<3>(), A_joint * in_C.tail<3>()};
  actor.wrenches[index(Side::parent)] = opposite(on_child, joint.gap);
}

namespace {

/// The law of a line or turn spring; nullptr of any other element.
const ForceLaw* law_of(const ForceElement& element) {
  if (const auto* line = std::get_if<LineSpring>(&element.what)) return &line->law;
  if (const auto* turn = std::get_if<TurnSpring>(&element.what)) return &turn->law;
  return nullptr;
}

bool has_regimes(const ForceElement& element) {
  const ForceLaw* law = law_of(element);
  return std::holds_alternative<Tire>(element.what) || (law != nullptr && has_regimes(*law));
}

bool has_regimes(const Joint& joint) {
  return std::any_of(joint.springs.begin(), joint.springs.end(),
                     [](const JointSpring& spring) { return has_regimes(spring.law); });
}

}  // namespace

bool AppliedForces::has_regimes(const Actor& actor) const {
  const ForceElement* element = element_of(actor);
  return element != nullptr ? cartesian::has_regimes(*element) : cartesian::has_regimes(model_.joints[*actor.joint()]);
}

bool AppliedForces::has_regimes() const {
  return std::any_of(model_.elements.begin(), model_.elements.end(),
                     [](const ForceElement& element) { return cartesian::has_regimes(element); }) ||
         std::any_of(model_.joints.begin(), model_.joints.end(),
                     [](const Joint& joint) { return cartesian::has_regimes(joint); });
}

std::string AppliedForces::name_of_regime(int actor) const {
  const Actor& of = actors_[actor];
  if (const std::optional<int> joint = of.joint()) {
    return fmt::format("the stop of joint '{}'", model_.joints[*joint].name);
  }
  const ForceElement& element = *element_of(of);
  return fmt::format("{} '{}'", std::holds_alternative<Tire>(element.what) ? "tire" : "the stop of", element.name);
}

void AppliedForces::lay_out_events() {
  for (std::size_t k = 0; k < actors_.size(); ++k) {
    const Actor& actor = actors_[k];
    if (!has_regimes(actor)) continue;
    const ForceElement* element = element_of(actor);
    const auto laws = static_cast<int>(actor.stop_regimes.size());
    const int n = element != nullptr && std::holds_alternative<Tire>(element->what) ? kTireEvents : kLawEvents * laws;
    event_owners_.insert(event_owners_.end(), static_cast<std::size_t>(n), static_cast<int>(k));
  }
  event_values_ = VecX::Zero(static_cast<Eigen::Index>(event_owners_.size()));
}

double* AppliedForces::write_event_functions(const Actor& actor, double t, double* next) const {
  const auto write = [&next](const auto& values) { next = std::copy(values.begin(), values.end(), next); };
  if (const std::optional<int> of_joint = actor.joint()) {
    const Joint& joint = model_.joints[*of_joint];
    for (std::size_t k = 0; k < joint.springs.size(); ++k) {
      const JointSpring& spring = joint.springs[k];
      const joints::Read& read = *read_of(*joint.type, spring.word);
      const ConstraintRow row = evaluate_read(read, spring.component, actor.motion);
      const double known = actor.known_q(first_q(*joint.type, spring.word) + spring.component);
      const double x = value_near(actor.spring_turns[k], row, known);
      write(event_functions_of(spring.law, actor.stop_regimes[k], x, rate_of(row, actor.motion)));
    }
    return next;
  }
  const ForceElement& element = *element_of(actor);
  const Marker& parent = actor.markers[index(Side::parent)];
  const Marker& child = actor.markers[index(Side::child)];
  if (const auto* tire = std::get_if<Tire>(&element.what)) {
    const TireOnRoad at = place_on_road(*tire, actor.regime.stretch, child, element.name, t);
    write(event_functions_of(*tire, actor.regime, at.contact));
    return next;
  }
  const ForceLaw& law = *law_of(element);
  if (std::holds_alternative<TurnSpring>(element.what)) {
    const ConstraintRow angle = evaluate_read(kSpringAngle, 0, actor.motion);
    write(event_functions_of(law, actor.stop_regimes.front(), angle.value, rate_of(angle, actor.motion)));
    return next;
  }
  const Vec3 line = child.point - parent.point;
  const double length = line.norm();
  const double rate = length > shortest_line_ ? line.dot(child.velocity - parent.velocity) / length : 0.0;
  write(event_functions_of(law, actor.stop_regimes.front(), length, rate));
  return next;
}

const VecX& AppliedForces::event_functions(double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y) {
  double* next = event_values_.data();
  for (Actor& actor : actors_) {
    if (!has_regimes(actor)) continue;
    for (const Side side : {Side::parent, Side::child}) {
      if (!actor.sits_on_moving_body(side)) continue;
      const Mat3 A = rotation_of(layout_.p(q, actor.ends[index(side)]->body).normalized());
      place_end(actor, side, A, q, Y);
    }
    place_relative(actor.markers[index(Side::parent)], actor.markers[index(Side::child)], actor.motion);
    move_relative(actor.markers[index(Side::parent)], actor.markers[index(Side::child)], actor.motion);
    next = write_event_functions(actor, t, next);
  }
  return event_values_;
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
    if (spring == nullptr) continue;
    const Marker& parent = actor.markers[index(Side::parent)];
    const Marker& child = actor.markers[index(Side::child)];
    const Vec3 rate = child.velocity - parent.velocity;
    const double speed = rate.norm();
    const double actuator = evaluate_actuator(spring->law, t);
    // The tension of ends that come together, and of ends that go apart: continuous if it only changes its sign.
    const double before = evaluate_resistance(spring->law, 0.0, -speed).force + actuator;
    const double behind = evaluate_resistance(spring->law, 0.0, speed).force + actuator;
    lines.push_back({&element->name, child.point - parent.point, rate, before != -behind});
  }
  return lines;
}

void AppliedForces::count_turns_from(const std::vector<VecX>& q) {
  for (Actor& actor : actors_) {
    if (const std::optional<int> joint = actor.joint()) actor.known_q = q[*joint];
  }
}

}  // namespace concord::cartesian
