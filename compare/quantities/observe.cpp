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
    require(static_cast<std::size_t>(evaluation.joints[k].tau.size()), speeds, "driver forces");
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

/// What acts on a joint speed: "driver" if there is one among others, "spring" if there is none, "couplings" if there
/// is nothing else.
const char* actor_on(const Model& model, int k, int speed) {
  const Joint& joint = model.joints[k];
  std::set<int> driven;
  std::set<int> sprung;
  add_speeds(joint, joint.drivers, driven);
  add_speeds(joint, joint.springs, sprung);
  if (driven.contains(speed)) return "driver";
  if (sprung.contains(speed)) return "spring";
  return model.is_coupled(k) ? "couplings" : "driver";
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
    for (const int speed : forced_speeds(model, k)) quantities_.push_back({Kind::driver, k, Side::child, speed});
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
  const auto found = std::find(quantities_.begin(), quantities_.end(), quantity);
  if (found == quantities_.end()) throw IncompleteResult("the layout has no such quantity");
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
  for (int k = 0; k < static_cast<int>(model_->joints.size()); ++k) {
    for (const int speed : forced_speeds(*model_, k)) values(row++) = evaluation.joints[k].tau(speed);
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
  for (std::size_t i = 1; i < model_->bodies.size(); ++i) {
    append(total_on_body(*model_, state, evaluation, static_cast<int>(i)).vector());
  }
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
  if (quantity.kind == Kind::driver) {
    return fmt::format("{} of joint {}", actor_on(model, quantity.owner, quantity.component), joint.name);
  }
  const std::string& body = model.bodies[joint.on(quantity.side).body].name;
  std::string owner = fmt::format("joint {} on {}", joint.name, body);
  if (quantity.kind == Kind::total) return owner + " (total wrench)";
  if (quantity.kind == Kind::reaction_global) return owner + " (global axes)";
  return owner;
}

std::string describe_component(const Quantity& quantity) {
  constexpr std::array kAxes{'x', 'y', 'z'};
  if (quantity.kind == Kind::driver) return fmt::format("tau_{}", quantity.component + 1);
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
  if (quantity.kind == Kind::driver) is_torque = turns(model, quantity.owner, quantity.component);
  if (quantity.kind == Kind::coupling) is_torque = is_turn(model, model.couplings[quantity.owner].terms.front());
  return is_torque ? "N m" : "N";
}

int speed_of(const Model& model, const CouplingTerm& term) {
  return first_u(*model.joints[term.joint].type, term.word) + term.component;
}

bool is_turn(const Model& model, const CouplingTerm& term) { return turns(model, term.joint, speed_of(model, term)); }

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

Wrench total_on_body(const Model& model, const State& state, const Evaluation& evaluation, int body) {
  Wrench sum;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Side side : kSides) {
      if (model.joints[k].on(side).body != body) continue;
      const Wrench& wrench = evaluation.joints[k].total_on(side).in_global;
      const Vec3 arm = joint_point(model, state, model.joints[k], side) - state.bodies[body].r;
      sum += Wrench{wrench.force, wrench.torque + arm.cross(wrench.force)};
    }
  }
  return sum;
}

}  // namespace concord::compare
