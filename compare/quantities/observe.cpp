#include "compare/quantities/observe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "compare/audit/joint_motion.h"

namespace concord::compare {

namespace {

void check_complete(const Model& model, const State& state, const Evaluation& evaluation) {
  const auto require = [&](std::size_t found, std::size_t expected, const char* what) {
    if (found != expected) {
      throw IncompleteResult(fmt::format("at t = {:.6g} s: {} {}, expected {}", state.t, found, what, expected));
    }
  };
  require(state.bodies.size(), model.bodies.size(), "bodies in the state");
  require(evaluation.bodies.size(), model.bodies.size(), "bodies in the evaluation");
  require(evaluation.joints.size(), model.joints.size(), "joints in the evaluation");
  require(evaluation.couplings.size(), model.couplings.size(), "couplings in the evaluation");
  require(evaluation.elements.size(), model.elements.size(), "force elements in the evaluation");
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const auto modes = static_cast<std::size_t>(model.bodies[i].n_modes());
    require(static_cast<std::size_t>(state.bodies[i].a.size()), modes, "modal coordinates");
    require(static_cast<std::size_t>(state.bodies[i].adot.size()), modes, "modal rates");
    require(static_cast<std::size_t>(evaluation.bodies[i].addot.size()), modes, "modal accelerations");
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const auto speeds = static_cast<std::size_t>(model.joints[k].type->n_u());
    require(static_cast<std::size_t>(evaluation.joints[k].tau.size()), speeds, "coordinate forces");
    for (const VecX& share : evaluation.joints[k].shares) {
      require(static_cast<std::size_t>(share.size()), speeds, "shares of coordinate forces");
    }
  }
}

template <class Actors>
void add_speeds(const Joint& joint, const Actors& actors, std::set<int>& speeds) {
  for (const auto& actor : actors) speeds.insert(first_u(*joint.type, actor.word) + actor.component);
}

std::vector<CouplingTerm> coupled_in(const Model& model, int k) {
  std::vector<CouplingTerm> terms;
  for (const Coupling& coupling : model.couplings) {
    std::copy_if(coupling.terms.begin(), coupling.terms.end(), std::back_inserter(terms),
                 [k](const CouplingTerm& term) { return term.joint == k; });
  }
  return terms;
}

/// What acts on a joint speed, if it acts alone.
const char* only_actor_on(const Model& model, int k, int speed) {
  if (is_shared(model, k, speed)) return "coordinate force";
  const std::vector<Actor> own = actors_on(model.joints[k], speed);
  return own.empty() ? "coupling" : name_of(own.front());
}

bool acts_at_rest(const ForceLaw& law) {
  return law.stiffness != 0.0 || law.preload != 0.0 || law.spring_table || law.lower || law.upper;
}

bool acts_by_its_rate(const ForceLaw& law) {
  const auto is_damped = [](const std::optional<SmoothStop>& stop) { return stop && stop->damping != 0.0; };
  return law.damping != 0.0 || law.damper_table || is_damped(law.lower) || is_damped(law.upper);
}

}  // namespace

const std::array<std::string, 6>& component_names() {
  static const std::array<std::string, 6> names{"F_x", "F_y", "F_z", "T_x", "T_y", "T_z"};
  return names;
}

QuantityLayout::QuantityLayout(const Model& model) : model_(&model) {
  const int joints = static_cast<int>(model.joints.size());
  const int bodies = static_cast<int>(model.bodies.size());
  for (const Kind kind : {Kind::reaction, Kind::reaction_global, Kind::total}) {
    for (int k = 0; k < joints; ++k) {
      for (const Side side : kSides) add_block(kind, k, side, 6);
    }
  }
  for (int k = 0; k < joints; ++k) {
    for (const int speed : forced_speeds(model, k)) quantities_.push_back({Kind::tau, k, Side::child, speed});
  }
  for (int k = 0; k < joints; ++k) {
    for (const int speed : forced_speeds(model, k)) {
      if (!is_shared(model, k, speed)) continue;
      for (const Actor actor : actors_on(model.joints[k], speed)) {
        quantities_.push_back({Kind::share, k, Side::child, speed, actor});
      }
    }
  }
  for (int k = 0; k < static_cast<int>(model.couplings.size()); ++k) add_block(Kind::coupling, k, Side::child, 1);
  for (std::size_t k = 0; k < model.elements.size(); ++k) {
    for (const Side side : kSides) {
      if (end_of(model.elements[k], side) != nullptr) add_block(Kind::element, static_cast<int>(k), side, 6);
    }
  }
  for (int i = 1; i < bodies; ++i) add_block(Kind::acceleration, i, Side::child, 6 + model.bodies[i].n_modes());
  for (int i = 1; i < bodies; ++i) add_block(Kind::body_sum, i, Side::child, 6);
}

void QuantityLayout::add_block(Kind kind, int owner, Side side, int components) {
  for (int c = 0; c < components; ++c) quantities_.push_back({kind, owner, side, c});
}

int QuantityLayout::row_of(const Quantity& quantity) const {
  const auto found = std::lower_bound(quantities_.begin(), quantities_.end(), quantity);
  if (found == quantities_.end() || *found != quantity) throw IncompleteResult("the layout has no such quantity");
  return static_cast<int>(found - quantities_.begin());
}

int QuantityLayout::first_row(Kind kind, int owner, Side side) const { return row_of({kind, owner, side, 0}); }

VecX QuantityLayout::observe(const State& state, const Evaluation& evaluation) const {
  check_complete(*model_, state, evaluation);
  VecX values(static_cast<Eigen::Index>(quantities_.size()));
  Eigen::Index row = 0;
  const auto append = [&](const auto& numbers) {
    values.segment(row, numbers.size()) = numbers;
    row += numbers.size();
  };
  const auto append_wrenches = [&](const auto& wrench_of) {
    for (const JointWrenches& joint : evaluation.joints) {
      for (const Side side : kSides) append(wrench_of(joint, side).vector());
    }
  };
  append_wrenches([](const JointWrenches& joint, Side side) { return joint.reaction_on(side).in_C; });
  append_wrenches([](const JointWrenches& joint, Side side) { return joint.reaction_on(side).in_global; });
  append_wrenches([](const JointWrenches& joint, Side side) { return joint.total_on(side).in_C; });
  for (; row < values.size(); ++row) {
    const Quantity& force = quantities_[static_cast<std::size_t>(row)];
    const bool is_share = force.kind == Kind::share;
    if (!is_share && force.kind != Kind::tau) break;
    const JointWrenches& joint = evaluation.joints[force.owner];
    values(row) = (is_share ? joint.share_of(force.actor) : joint.tau)(force.component);
  }
  for (const double force : evaluation.couplings) values(row++) = force;
  for (std::size_t k = 0; k < model_->elements.size(); ++k) {
    for (const Side side : kSides) {
      if (end_of(model_->elements[k], side) == nullptr) continue;
      append(evaluation.elements[k].on_side(side).in_C.vector());
    }
  }
  for (std::size_t i = 1; i < model_->bodies.size(); ++i) {
    append(evaluation.bodies[i].vdot);
    append(evaluation.bodies[i].omegadot);
    append(evaluation.bodies[i].addot);
  }
  const std::vector<Wrench> totals = totals_on_bodies(*model_, state, evaluation);
  for (std::size_t i = 1; i < totals.size(); ++i) append(totals[i].vector());
  return values;
}

VecX QuantityLayout::observe_to_judge(const State& state, const Evaluation& evaluation, std::string_view solver) const {
  constexpr double kLargest = 1e150;
  VecX values = observe(state, evaluation);
  for (Eigen::Index row = 0; row < values.size(); ++row) {
    if (std::abs(values(row)) <= kLargest) continue;
    const Quantity& quantity = quantities_[static_cast<std::size_t>(row)];
    const std::string what = std::isfinite(values(row))
                                 ? fmt::format("is {:.3g}, beyond the {:g} that can be judged,", values(row), kLargest)
                                 : "is not a number";
    throw IncompleteResult(fmt::format("{}: {}, {} {} at t = {:.6g} s", solver, describe_owner(*model_, quantity),
                                       describe_component(quantity), what, state.t));
  }
  return values;
}

std::string describe_owner(const Model& model, const Quantity& quantity) {
  if (quantity.kind == Kind::acceleration) return fmt::format("body {}", model.bodies[quantity.owner].name);
  if (quantity.kind == Kind::body_sum) return fmt::format("all joints on {}", model.bodies[quantity.owner].name);
  if (quantity.kind == Kind::coupling) return fmt::format("coupling {}", model.couplings[quantity.owner].name);
  if (quantity.kind == Kind::element) {
    const ForceElement& element = model.elements[quantity.owner];
    return fmt::format("force element {} on {}", element.name, model.bodies[end_of(element, quantity.side)->body].name);
  }
  const Joint& joint = model.joints[quantity.owner];
  if (quantity.kind == Kind::tau) {
    return fmt::format("{} of joint {}", only_actor_on(model, quantity.owner, quantity.component), joint.name);
  }
  if (quantity.kind == Kind::share) return fmt::format("{} of joint {}", name_of(quantity.actor), joint.name);
  const std::string& body = model.bodies[joint.on(quantity.side).body].name;
  std::string owner = fmt::format("joint {} on {}", joint.name, body);
  if (quantity.kind == Kind::total) return owner + " (total wrench)";
  if (quantity.kind == Kind::reaction_global) return owner + " (global axes)";
  return owner;
}

std::string describe_component(const Quantity& quantity) {
  constexpr std::array kAxes{'x', 'y', 'z'};
  if (quantity.kind == Kind::tau || quantity.kind == Kind::share) return fmt::format("tau_{}", quantity.component + 1);
  if (quantity.kind == Kind::coupling) return "force";
  if (quantity.kind != Kind::acceleration) return component_names()[quantity.component];
  if (quantity.component < 3) return fmt::format("vdot_{}", kAxes[quantity.component]);
  if (quantity.component < 6) return fmt::format("omegadot_{}", kAxes[quantity.component - 3]);
  return fmt::format("addot_{}", quantity.component - 5);
}

namespace {

bool turns(const Model& model, int joint, int speed) {
  return turning_speeds(*model.joints[joint].type).at(static_cast<std::size_t>(speed));
}

}  // namespace

std::string unit_of(const Model& model, const Quantity& quantity) {
  if (quantity.kind == Kind::acceleration) {
    return quantity.component < 3 ? "m/s2" : quantity.component < 6 ? "rad/s2" : "1/s2";
  }
  bool is_torque = quantity.component >= 3;
  if (quantity.kind == Kind::tau || quantity.kind == Kind::share)
    is_torque = turns(model, quantity.owner, quantity.component);
  if (quantity.kind == Kind::coupling) is_torque = is_turn(model, model.couplings[quantity.owner].terms.front());
  return is_torque ? "N m" : "N";
}

int speed_of(const Model& model, const CouplingTerm& term) {
  return first_u(*model.joints[term.joint].type, term.word) + term.component;
}

bool is_turn(const Model& model, const CouplingTerm& term) { return turns(model, term.joint, speed_of(model, term)); }

const char* name_of(Actor actor) {
  constexpr std::array kNames{"driver", "motor", "spring", "damper"};
  return kNames[index(actor)];
}

std::vector<Actor> actors_on(const Joint& joint, int speed) {
  const auto acts_there = [&](const auto& one) { return first_u(*joint.type, one.word) + one.component == speed; };
  const auto has_law = [&](const auto& does) {
    return std::any_of(joint.springs.begin(), joint.springs.end(),
                       [&](const JointSpring& spring) { return acts_there(spring) && does(spring.law); });
  };
  std::vector<Actor> actors;
  if (std::any_of(joint.drivers.begin(), joint.drivers.end(), acts_there)) actors.push_back(Actor::driver);
  if (has_law([](const ForceLaw& law) { return law.actuator.has_value(); })) actors.push_back(Actor::motor);
  if (has_law(acts_at_rest)) actors.push_back(Actor::spring);
  if (has_law(acts_by_its_rate)) actors.push_back(Actor::damper);
  return actors;
}

bool is_shared(const Model& model, int k, int speed) {
  std::size_t actors = actors_on(model.joints[k], speed).size();
  for (const CouplingTerm& term : coupled_in(model, k)) actors += speed_of(model, term) == speed ? 1 : 0;
  return actors > 1;
}

bool is_told_force(const Model& model, const Quantity& quantity) {
  const bool is_sum = quantity.kind == Kind::tau && is_shared(model, quantity.owner, quantity.component);
  return is_scalar_force(quantity.kind) && !is_sum;
}

std::vector<int> forced_speeds(const Model& model, int k) {
  std::set<int> speeds;
  add_speeds(model.joints[k], model.joints[k].drivers, speeds);
  add_speeds(model.joints[k], model.joints[k].springs, speeds);
  for (const CouplingTerm& term : coupled_in(model, k)) speeds.insert(speed_of(model, term));
  return {speeds.begin(), speeds.end()};
}

Vec3 joint_point(const Model& model, const State& state, const Joint& joint, Side side) {
  const Attachment& attachment = joint.on(side);
  if (attachment.body == kGround) return attachment.point_L;
  const BodyState& body = state.bodies[attachment.body];
  Vec3 s_P_L = attachment.point_L;
  if (model.bodies[attachment.body].n_modes() > 0) s_P_L += attachment.Psi_t_L * body.a;
  return body.r + rotation_of(body.p) * s_P_L;
}

std::vector<Wrench> totals_on_bodies(const Model& model, const State& state, const Evaluation& evaluation) {
  std::vector<Wrench> sums(model.bodies.size());
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Side side : kSides) {
      const int body = model.joints[k].on(side).body;
      const Wrench& wrench = evaluation.joints[k].total_on(side).in_global;
      const Vec3 arm = joint_point(model, state, model.joints[k], side) - state.bodies[body].r;
      sums[body] += Wrench{wrench.force, wrench.torque + arm.cross(wrench.force)};
    }
  }
  return sums;
}

}  // namespace concord::compare
