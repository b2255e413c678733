#include "relative/forces/applied_forces.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "relative/bodies/velocity_transformation.h"
#include "relative/forces/element_wrench.h"

namespace concord::relative {

AppliedForces::AppliedForces(const Kinematics& kinematics, const Closure& closure)
    : kinematics_(&kinematics),
      closure_(&closure),
      on_body_(kinematics.topology().links.size(), Vec6::Zero()),
      on_child_of_cut_(closure.cuts().size(), Vec6::Zero()),
      wrenches_(kinematics.model().elements.size()),
      tau_(VecX::Zero(kinematics.topology().n_u)),
      tau_of_motors_(tau_) {
  for (const Link& link : kinematics.topology().links) {
    on_modes_.emplace_back(VecX::Zero(kinematics.topology().modes[link.body].n_u));
  }
  lay_out_elements();
  lay_out_springs();
}

void AppliedForces::lay_out_elements() {
  for (const ForceElement& statement : kinematics_->model().elements) {
    Element element{&statement, {}, {}, {}, {}, {}};
    if (std::holds_alternative<Tire>(statement.what)) {
      element.tire = static_cast<int>(tires_.size());
      tires_.push_back({&statement, elements_.size(), {}, {}});
      has_regimes_ = true;
    }
    if (const auto* line = std::get_if<LineSpring>(&statement.what)) element.law = add_law(line->law, statement.name);
    if (const auto* turn = std::get_if<TurnSpring>(&statement.what)) element.law = add_law(turn->law, statement.name);
    for (const Side side : {Side::parent, Side::child}) {
      const Attachment* end = end_of(statement, side);
      if (end == nullptr) continue;
      element.ends.emplace_back(fmt::format("force element '{}'", statement.name),
                                kinematics_->topology().from_reference_point(*end));
      element.bodies[index(side)] = BodyIndex(end->body);
    }
    if (std::holds_alternative<TurnSpring>(statement.what)) turn_springs_.push_back(elements_.size());
    elements_.push_back(std::move(element));
  }
}

void AppliedForces::lay_out_springs() {
  const Model& model = kinematics_->model();
  const Topology& topology = kinematics_->topology();
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    for (const JointSpring& spring : joint.springs) {
      springs_.push_back({add_law(spring.law, joint.name),
                          topology.joints[k].first_q + first_q(*joint.type, spring.word) + spring.component,
                          topology.joints[k].first_u + first_u(*joint.type, spring.word) + spring.component});
    }
  }
  for (const CutIndex c : upward<CutIndex>(closure_->cuts().size())) {
    if (!model.joints[closure_->cuts()[c].joint].springs.empty()) sprung_cuts_.push_back(c);
  }
}

int AppliedForces::add_law(const ForceLaw& law, const std::string& owner) {
  laws_.push_back({{&law, {}, 0.0, 0.0}, &owner});
  has_regimes_ = has_regimes_ || concord::has_regimes(law);
  return static_cast<int>(laws_.size()) - 1;
}

void AppliedForces::update(const Motion& motion) {
  if (!any()) return;
  clear();
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    move_ends(elements_[e], motion);
    apply_element(motion.t(), elements_[e], wrenches_[e]);
  }
  apply_springs(motion);
}

void AppliedForces::count_turns_from(const State& state) {
  for (const std::size_t e : turn_springs_) elements_[e].angle.known = {state.t, state.known_angle(e), 0.0};
}

void AppliedForces::count_turns_as(const AppliedForces& other) {
  for (const std::size_t e : turn_springs_) elements_[e].angle = other.elements_[e].angle;
}

void AppliedForces::follow_turns() {
  for (const std::size_t e : turn_springs_) elements_[e].angle.follow();
}

void AppliedForces::require_seen_turns() const {
  constexpr double kQuarterTurn = 0.5 * std::numbers::pi;
  for (const std::size_t e : turn_springs_) {
    if (std::abs(elements_[e].angle.stray()) <= kQuarterTurn) continue;
    throw SolverError(
        fmt::format("relative: force element '{}': its turns cannot be counted: its rate changes too much in one step",
                    elements_[e].statement->name));
  }
}

std::vector<double> AppliedForces::spring_angles(const Motion& motion) const {
  std::vector<double> angles(elements_.size(), 0.0);
  for (const std::size_t e : turn_springs_) {
    Element spring = elements_[e];
    move_ends(spring, motion);
    const EndTurn turn = turn_between(spring.ends.front(), spring.ends.back());
    angles[e] = spring.angle.count(motion.t(), turn.angle, turn.xdot);
  }
  return angles;
}

void AppliedForces::clear() {
  for (Vec6& force : on_body_) force.setZero();
  for (VecX& force : on_modes_) force.setZero();
  tau_.setZero();
  tau_of_motors_.setZero();
  power_ = 0.0;
}

void AppliedForces::move_ends(Element& element, const Motion& motion) const {
  const std::size_t without = 2 - element.ends.size();
  for (std::size_t e = 0; e < element.ends.size(); ++e) {
    const BodyIndex body = element.bodies[e + without];
    const Span& modes = kinematics_->topology().modes[body];
    element.ends[e].deform(motion.q().data() + modes.first_q, motion.u().data() + modes.first_u);
    element.ends[e].compute_point_motion(kinematics_->body(body));
  }
}

Vec6 AppliedForces::exerted(const Load& load, double t, const Element& element) const {
  return wrench_of(load, t, kinematics_->body(BodyIndex(load.at.body)).A, element.ends.back());
}

Vec6 AppliedForces::exerted(const LineSpring& spring, double t, const Element& element) {
  return wrench_of(spring, t, element.ends.front(), element.ends.back(), kinematics_->size().length(),
                   element.statement->name, laws_[*element.law].law_in_regime, regimes_are_frozen_);
}

Vec6 AppliedForces::exerted(const TurnSpring& spring, double t, Element& element) {
  return wrench_of(spring, t, element.ends.front(), element.ends.back(), element.statement->name, element.angle,
                   laws_[*element.law].law_in_regime, regimes_are_frozen_);
}

Vec6 AppliedForces::exerted(const Tire& tire, double /*t*/, const Element& element) {
  const JointPoint& wheel = element.ends.back();
  TireState& state = tires_[*element.tire];
  const int stretch = regimes_are_frozen_ ? state.regime.stretch : stretch_at(*tire.road, wheel.r.x());
  const ContactFrame frame = contact_of(tire, stretch, wheel, element.statement->name);
  state.contact = frame.contact;
  if (!regimes_are_frozen_) state.regime = regime_at(tire, frame.contact);
  return wrench_at_center(frame, evaluate(tire, state.regime, frame.contact));
}

double AppliedForces::departure_of(const TireState& state) const {
  const Tire& tire = std::get<Tire>(state.statement->what);
  const JointPoint& wheel = elements_[state.element].ends.back();
  const ContactFrame own = contact_of(tire, stretch_at(*tire.road, wheel.r.x()), wheel, state.statement->name);
  const Vec3 force = wrench_at_center(own, evaluate(tire, regime_at(tire, own.contact), own.contact)).head<3>();
  const Vec3& exerted = wrenches_[state.element].on_side(Side::child).in_global.force;
  return (exerted - force).norm() / (tire.stiffness * tire.radius);
}

std::optional<AppliedForces::Contact> AppliedForces::departed_contact() const {
  for (const TireState& tire : tires_) {
    if (departure_of(tire) > kLargestDeparture) return Contact{"tire", &tire.statement->name};
  }
  for (const OwnedLaw& law : laws_) {
    if (law.law_in_regime.departure() > kLargestDeparture) return Contact{"law of", law.owner};
  }
  return std::nullopt;
}

AppliedForces::Least AppliedForces::least() const {
  Least found{std::numeric_limits<double>::infinity(), {"", nullptr}};
  const auto take = [&found](double value, const char* kind, const std::string& owner) {
    if (found.contact.owner == nullptr || value < found.value) found = {value, {kind, &owner}};
  };
  for (const TireState& tire : tires_) {
    take(event_function_of(std::get<Tire>(tire.statement->what), tire.regime, tire.contact), "tire",
         tire.statement->name);
  }
  for (const OwnedLaw& law : laws_) {
    if (!concord::has_regimes(*law.law_in_regime.law)) continue;
    const auto values = law.law_in_regime.event_functions();
    take(*std::min_element(values.begin(), values.end()), "law of", *law.owner);
  }
  return found;
}

AppliedForces::ContactRegimes AppliedForces::contact_regimes() const {
  ContactRegimes regimes;
  for (const TireState& tire : tires_) regimes.of_tires.push_back(tire.regime);
  for (const OwnedLaw& law : laws_) regimes.of_laws.push_back(law.law_in_regime.regime);
  return regimes;
}

void AppliedForces::freeze_regimes(const ContactRegimes& regimes) {
  for (std::size_t k = 0; k < tires_.size(); ++k) tires_[k].regime = regimes.of_tires[k];
  for (std::size_t k = 0; k < laws_.size(); ++k) laws_[k].law_in_regime.regime = regimes.of_laws[k];
  freeze_regimes();
}

void AppliedForces::write_event_functions(Eigen::Ref<VecX> values) const {
  double* next = values.data();
  const auto write = [&next](const auto& own) { next = std::copy(own.begin(), own.end(), next); };
  for (const TireState& tire : tires_) {
    write(event_functions_of(std::get<Tire>(tire.statement->what), tire.regime, tire.contact));
  }
  for (const OwnedLaw& law : laws_) write(law.law_in_regime.event_functions());
}

std::string AppliedForces::least_contact() const {
  const Least found = least();
  return found.contact.owner == nullptr ? "" : found.contact.name();
}

std::string AppliedForces::Contact::name() const { return fmt::format("{} '{}'", kind, *owner); }

bool AppliedForces::has_line_springs() const {
  return std::any_of(elements_.begin(), elements_.end(), [](const Element& element) {
    return std::holds_alternative<LineSpring>(element.statement->what);
  });
}

std::vector<SpringLine> AppliedForces::lines(double t) const {
  std::vector<SpringLine> found;
  for (const Element& element : elements_) {
    const auto* spring = std::get_if<LineSpring>(&element.statement->what);
    if (spring == nullptr) continue;
    const JointPoint& parent = element.ends.front();
    const JointPoint& child = element.ends.back();
    const Vec3 velocity = child.v - parent.v;
    const double jump = jump_where_ends_pass(*spring, t, velocity.norm());
    found.push_back({&element.statement->name, child.r - parent.r, velocity, jump != 0.0});
  }
  return found;
}

/// On the child's body, and the answer on the parent's, if there is one.
void AppliedForces::apply_element(double t, Element& element, ElementWrenches& wrenches) {
  const JointPoint& child = element.ends.back();
  const Vec6 on_child =
      std::visit([&](const auto& what) -> Vec6 { return exerted(what, t, element); }, element.statement->what);
  apply_wrench(element.bodies[index(Side::child)], child, on_child);
  wrenches.on[index(Side::child)] = in_both_frames(child.A, on_child);
  if (element.ends.size() == 1) return;
  const JointPoint& parent = element.ends.front();
  const Vec6 on_parent = opposite_wrench_at(on_child, child.r, parent.r);
  apply_wrench(element.bodies[index(Side::parent)], parent, on_parent);
  wrenches.on[index(Side::parent)] = in_both_frames(parent.A, on_parent);
}

/// tau = actuator - resistance (R31).
void AppliedForces::apply_springs(const Motion& motion) {
  const VecX& q = motion.q();
  const VecX& u = motion.u();
  for (Spring& spring : springs_) {
    LawInRegime& law_in_regime = laws_[spring.law].law_in_regime;
    spring.place = kinematics_->with_turns(spring.q, q(spring.q));
    const double of_motor = evaluate_actuator(*law_in_regime.law, motion.t());
    const double tau = of_motor - law_in_regime.resist(spring.place, u(spring.u), regimes_are_frozen_);
    tau_of_motors_(spring.u) += of_motor;
    tau_(spring.u) += tau;
    power_ += tau * u(spring.u);
  }
  for (const CutIndex c : sprung_cuts_) {
    const Closure::Cut& cut = closure_->cuts()[c];
    const Span& span = kinematics_->topology().joints[cut.joint];
    const JointPoint& parent = kinematics_->point(cut.joint, Side::parent);
    const JointPoint& child = kinematics_->point(cut.joint, Side::child);
    const JointVector tau = tau_.segment(span.first_u, span.n_u);
    const Vec6 wrench = kinematics_->mobilizer(cut.joint).coordinate_wrench(cut.measure.motion_at(), tau);
    on_child_of_cut_[c] << parent.A * wrench.head<3>(), parent.A * wrench.tail<3>();
    const double power_so_far = power_;  // the springs' power has been counted by their coordinates
    const Joint& joint = kinematics_->model().joints[cut.joint];
    apply_wrench(BodyIndex(joint.on(Side::child).body), child, on_child_of_cut_[c]);
    apply_wrench(BodyIndex(joint.on(Side::parent).body), parent,
                 opposite_wrench_at(on_child_of_cut_[c], child.r, parent.r));
    power_ = power_so_far;
  }
}

void AppliedForces::write_tau_of_springs(VecX& tau) const {
  tau.setZero();
  for (const Spring& spring : springs_) {
    tau(spring.u) -= evaluate_resistance(*laws_[spring.law].law_in_regime.law, spring.place, 0.0).force;
  }
}

void AppliedForces::apply_wrench(BodyIndex body, const JointPoint& point, const Vec6& wrench) {  // (R8)
  if (body == kGround) return;
  power_ += wrench.head<3>().dot(point.v) + wrench.tail<3>().dot(point.omega);
  const LinkIndex link = *kinematics_->topology().link_of_body[body];
  on_body_[link] += shift_wrench(wrench, point.lever);
  if (point.n_modes() > 0) on_modes_[link].noalias() += point.Ga().transpose().lazyProduct(wrench);
}

}  // namespace concord::relative
