#include "compare/invariance/units.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "compare/invariance/laws.h"

namespace concord::compare::invariance {

namespace {

std::optional<ForceTable> table_in_units(const std::optional<ForceTable>& table, double x, double force) {
  if (!table) return {};
  const SplineTable points = scaled(table->points(), x, force);
  return ForceTable(points.times(), points.values());
}

/// A force law over a length or an angle.
ForceLaw law_in_units(ForceLaw law, bool over_length, const Units& units) {
  const double x = units.coordinate(over_length);
  const double force = units.force_on(over_length);
  law.stiffness *= force / x;
  law.damping *= force / x * units.time;
  law.free *= x;
  law.preload *= force;
  law.spring_table = table_in_units(law.spring_table, x, force);
  law.damper_table = table_in_units(law.damper_table, x / units.time, force);
  for (std::optional<SmoothStop>* stop : {&law.lower, &law.upper}) {
    if (!*stop) continue;
    (*stop)->at *= x;
    (*stop)->width *= x;
    (*stop)->stiffness *= force / x;
    (*stop)->damping *= force / x * units.time;
  }
  if (law.actuator) law.actuator = scaled(*law.actuator, force, units.time);
  return law;
}

void tell_attachment(Attachment& side, const Units& units) {
  side.point_L *= units.length;
  side.Psi_t_L *= units.length / units.modal;
  side.Psi_r_L /= units.modal;
}

void tell_modes(ModalData& modal, const Units& units) {
  const double stiffness = units.torque() / (units.modal * units.modal);
  modal.beam.reset();
  modal.stiffness *= stiffness;
  modal.damping *= stiffness * units.time;
  modal.frequencies /= units.time;
  VecX scale = VecX::Constant(modal.G.rows(), units.length / units.modal);
  scale(0) = 1.0;
  scale.segment<3>(1).setConstant(units.length);
  modal.G = units.mass * (scale.asDiagonal() * modal.G * scale.asDiagonal());
  for (ModalNode& node : modal.nodes) {
    node.s0_L *= units.length;
    node.Psi_t_L *= units.length / units.modal;
    node.Psi_r_L /= units.modal;
  }
  for (MassPoint& point : modal.mass_points) {
    point.mass *= units.mass;
    point.s0_L *= units.length;
    point.Psi_t_L *= units.length / units.modal;
  }
}

void tell_body(Body& body, const Units& units) {
  if (body.pose_guess) body.pose_guess->r *= units.length;
  body.a_start *= units.modal;
  body.adot_start *= units.modal / units.time;
  body.mass *= units.mass;
  body.center_of_mass_L *= units.length;
  body.inertia_L *= units.mass * units.length * units.length;
  if (body.modal) tell_modes(*body.modal, units);
}

/// The lead of a thread: how far a motion of one coordinate leads for each radian.
double lead_of(const joints::FunctionOfCoordinates& motion) {
  joints::FunctionOfCoordinates::Motion at;
  const double q = 1.0;
  const double u = 0.0;
  motion.evaluate(&q, &u, at);
  return at.placement.d.norm();
}

bool has_motion_by_functions(const joints::JointType& type) {
  return !type.permits.empty() && function_of(type.permits.front()) != nullptr;
}

/// The length that a joint type with a parameter states: of its arm, its rolling radius, or its lead; nothing where
/// none of them gives the type again.
std::optional<double> length_of(const joints::JointType& type) {
  if (type.parameters.size() != 1) return std::nullopt;
  for (const joints::Permit& word : type.permits) {
    if (arm_of(word)) return joints::stated_length(word);
    if (const joints::FunctionOfCoordinates* motion = function_of(word)) {
      const bool is_thread = type.name == "screw" && motion->n() == 1;
      return is_thread ? std::optional(lead_of(*motion)) : std::nullopt;
    }
  }
  for (const joints::ForbidSpeed& word : type.forbids_speeds) return joints::stated_length(word);
  return std::nullopt;
}

void tell_joint(Joint& joint, const Units& units) {
  for (Attachment& side : joint.sides) tell_attachment(side, units);
  const joints::JointType& type = *joint.type;
  for (std::size_t word = 0; word < joint.start.size(); ++word) {
    const auto grows = [&](Eigen::Index c) {
      return units.coordinate(is_length(type.permits[word], static_cast<int>(c)));
    };
    VecX& q = joint.start[word].q;
    VecX& u = joint.start[word].u;
    for (Eigen::Index c = 0; c < q.size(); ++c) q(c) *= grows(c);
    for (Eigen::Index c = 0; c < u.size(); ++c) u(c) *= grows(c) / units.time;
  }
  for (Driver& driver : joint.drivers) {
    const bool slides = is_length(type.permits[static_cast<std::size_t>(driver.word)], driver.component);
    driver.law = scaled(driver.law, units.coordinate(slides), units.time);
  }
  for (JointSpring& spring : joint.springs) {
    const bool slides = is_length(type.permits[static_cast<std::size_t>(spring.word)], spring.component);
    spring.law = law_in_units(std::move(spring.law), slides, units);
  }
  if (type.with_parameters == nullptr) return;
  const std::optional<double> length = length_of(type);
  if (!length) throw std::logic_error("no rule to read the parameter of a joint of type " + type.name);
  joint.own_type = std::make_shared<const joints::JointType>(type.with_parameters({*length * units.length}));
  joint.type = joint.own_type.get();
}

Road road_in_units(Road road, const Units& units) {
  if (auto* flat = std::get_if<FlatRoad>(&road.profile)) flat->height *= units.length;
  if (auto* bump = std::get_if<HalfSineBump>(&road.profile)) {
    bump->start *= units.length;
    bump->length *= units.length;
    bump->height *= units.length;
  }
  if (auto* table = std::get_if<RoadTable>(&road.profile)) {
    *table = {scaled(table->spline, units.length, units.length), table->first * units.length,
              table->last * units.length};
  }
  return road;
}

/// A quantity of a force element, told in other units.
struct QuantityInUnits {
  Units units;

  void operator()(const elements::Word& /*word*/) const {}
  void operator()(const elements::Scalar<double>& number) const { number.value *= of(number.of); }
  void operator()(const elements::Vector<Vec3>& vector) const { vector.value *= of(vector.of); }
  void operator()(const elements::Wrench6<Vec6>& wrench) const {
    wrench.value = wrench_units().cwiseProduct(wrench.value);
  }
  void operator()(const elements::WrenchMatrix<Mat6>& matrix) const {
    Vec6 motion;
    motion << Vec3::Constant(units.length), Vec3::Ones();
    const Vec6 per_motion = motion.cwiseInverse();
    matrix.value = wrench_units().asDiagonal() * matrix.value * per_motion.asDiagonal();
    if (matrix.per_rate) matrix.value *= units.time;
  }
  void operator()(const elements::LawOverCoordinate<ForceLaw>& spring) const {
    spring.value = law_in_units(std::move(spring.value), spring.over_length, units);
  }
  void operator()(const elements::FactorOverTime<TimeFunction>& law) const {
    law.value = scaled(law.value, 1.0, units.time);
  }
  void operator()(const elements::RoadBelow<std::shared_ptr<const Road>>& road) const {
    road.value = std::make_shared<const Road>(road_in_units(*road.value, units));
  }

 private:
  [[nodiscard]] double of(const elements::Dimension& dimension) const {
    return std::pow(units.force(), dimension.force) * std::pow(units.length, dimension.length) *
           std::pow(units.time, dimension.time);
  }
  [[nodiscard]] Vec6 wrench_units() const {
    Vec6 wrench;
    wrench << Vec3::Constant(units.force()), Vec3::Constant(units.torque());
    return wrench;
  }
};

void tell_element(ForceElement& element, const Units& units) {
  for (Attachment& end : ends_of(element)) tell_attachment(end, units);
  each_quantity(element, QuantityInUnits{units});
}

}  // namespace

std::optional<std::string> why_no_other_units(const Model& model) {
  for (const Joint& joint : model.joints) {
    const joints::JointType& type = *joint.type;
    const bool is_known =
        type.with_parameters != nullptr ? length_of(type).has_value() : !has_motion_by_functions(type);
    if (!is_known) return fmt::format("joint {}: type {} is given by functions of lengths", joint.name, type.name);
  }
  return std::nullopt;
}

Model told_in_units(Model model, const Units& units) {
  model.gravity *= units.length / (units.time * units.time);
  model.run.until *= units.time;
  for (Coupling& coupling : model.couplings) {
    for (CouplingTerm& term : coupling.terms) {
      const joints::JointType& type = *model.joints[static_cast<std::size_t>(term.joint)].type;
      term.factor /= units.coordinate(is_length(type.permits[static_cast<std::size_t>(term.word)], term.component));
    }
  }
  for (Body& body : model.bodies) tell_body(body, units);
  for (Joint& joint : model.joints) tell_joint(joint, units);
  for (ForceElement& element : model.elements) tell_element(element, units);
  return model;
}

namespace {

using Types = std::vector<const joints::JointType*>;

/// Calls `edit` with joint, word, index of the component among q, and that among u (or -1).
template <class Edit>
void for_each_coordinate(const Types& types, const Edit& edit) {
  for (std::size_t k = 0; k < types.size(); ++k) {
    for (std::size_t word = 0; word < types[k]->permits.size(); ++word) {
      const joints::Permit& permit = types[k]->permits[word];
      const int q = first_q(*types[k], static_cast<int>(word));
      const int u = first_u(*types[k], static_cast<int>(word));
      for (int c = 0; c < n_q(permit); ++c) edit(k, is_length(permit, c), q + c, c < n_u(permit) ? u + c : -1);
    }
  }
}

/// What a solver finds in other units, told in the first ones.
Evaluation back_from_units(Evaluation evaluation, const Units& units, const Types& types) {
  const double squared = units.time * units.time;
  for (BodyAcceleration& body : evaluation.bodies) {
    body.vdot *= squared / units.length;
    body.omegadot *= squared;
    body.addot *= squared / units.modal;
  }
  for_each_wrench(evaluation, [&](SideWrench& side) {
    for (Wrench* wrench : {&side.in_C, &side.in_global}) {
      wrench->force /= units.force();
      wrench->torque /= units.torque();
    }
  });
  for (double& force : evaluation.couplings) force /= units.torque();
  for_each_coordinate(types, [&](std::size_t k, bool slides, int, int u) {
    if (u < 0) return;
    evaluation.joints[k].tau(u) /= units.force_on(slides);
    for (VecX& share : evaluation.joints[k].shares) share(u) /= units.force_on(slides);
  });
  return evaluation;
}

State state_in_units(State state, const Units& units, const Types& types) {
  state.t *= units.time;
  for (BodyState& body : state.bodies) {
    body.r *= units.length;
    body.v *= units.length / units.time;
    body.omega /= units.time;
    body.a *= units.modal;
    body.adot *= units.modal / units.time;
  }
  for_each_coordinate(types, [&](std::size_t k, bool slides, int q, int u) {
    state.q[k](q) *= units.coordinate(slides);
    if (u >= 0) state.u[k](u) *= units.coordinate(slides) / units.time;
  });
  return state;
}

}  // namespace

Change in_units(const Model& first, const Units& units) {
  // Types with parameters belong to their joints: the change keeps them.
  auto told = std::make_shared<const Model>(first);
  Types types;
  for (const Joint& joint : told->joints) types.push_back(joint.type);
  const Units inverse{1.0 / units.length, 1.0 / units.mass, 1.0 / units.time, 1.0 / units.modal};
  Change change;
  change.model = [units](Model model) { return told_in_units(std::move(model), units); };
  change.state = [units, types, told](State state) { return state_in_units(std::move(state), units, types); };
  change.back = [inverse, types, told](State state) { return state_in_units(std::move(state), inverse, types); };
  change.evaluation = [units, types, told](const State&, Evaluation evaluation) {
    return back_from_units(std::move(evaluation), units, types);
  };
  return change;
}

}  // namespace concord::compare::invariance
