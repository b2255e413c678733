#include "compare/analyses/inverse.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "common/error.h"
#include "common/joints/named_coordinates.h"
#include "compare/audit/joint_motion.h"

namespace concord::compare::analyses {

namespace {

[[noreturn]] void refuse(const Model& model, const Joint& joint, const std::string& message) {
  const SourceLocation where = joint.where.file.empty() ? SourceLocation{model.file, 0, 0} : joint.where;
  throw InputError(where, fmt::format("inverse: joint '{}': {}", joint.name, message));
}

void check_asked(const Model& model, const std::vector<AskedAcceleration>& asked,
                 const std::vector<Prescribed>& coordinates) {
  for (const AskedAcceleration& one : asked) {
    const std::string name = fmt::format("{} of {}", one.coordinate, one.joint);
    const bool is_kept = std::any_of(coordinates.begin(), coordinates.end(),
                                     [&](const Prescribed& kept) { return kept.name(model) == name; });
    const auto same = [&](const AskedAcceleration& other) {
      return other.joint == one.joint && other.coordinate == one.coordinate;
    };
    if (std::count_if(asked.begin(), asked.end(), same) > 1) {
      throw InputError(one.where, fmt::format("inverse: two accelerations are asked for {}", name));
    }
    if (is_kept) continue;
    std::vector<std::string> names;
    for (const Prescribed& kept : coordinates) names.push_back(kept.name(model));
    throw InputError(one.where, fmt::format("inverse: an acceleration is asked for {}, which {} does not keep at its "
                                            "start; it keeps {}",
                                            name, model.file, fmt::join(names, ", ")));
  }
}

/// Makes guesses of so many kept coordinates (three of a ball), so that the machine still starts.
std::optional<Model> with_fewer_kept(const Model& model, int surplus, const std::function<bool(const Model&)>& starts) {
  constexpr std::size_t kMostWords = 12;  // beyond, the choices are too many to try each
  std::vector<std::pair<std::size_t, std::size_t>> kept;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (std::size_t word = 0; word < model.joints[k].start.size(); ++word) {
      if (model.joints[k].start[word].role_q == StartRole::keep) kept.emplace_back(k, word);
    }
  }
  if (kept.size() > kMostWords) return std::nullopt;
  for (std::size_t choice = 1; choice < std::size_t{1} << kept.size(); ++choice) {
    Model fewer = model;
    int released = 0;
    for (std::size_t one = 0; one < kept.size(); ++one) {
      if ((choice >> one & 1U) == 0) continue;
      WordStart& start = fewer.joints[kept[one].first].start[kept[one].second];
      start.role_q = StartRole::guess;
      released += static_cast<int>(start.u.size());
    }
    if (released == surplus && starts(fewer)) return fewer;
  }
  return std::nullopt;
}

}  // namespace

int Prescribed::speed(const Model& model) const { return first_u(*model.joints[joint].type, word) + component; }

std::string Prescribed::name(const Model& model) const {
  return fmt::format("{} of {}", speed_names(*model.joints[joint].type).at(static_cast<std::size_t>(speed(model))),
                     model.joints[joint].name);
}

std::vector<Prescribed> prescribed_coordinates(const Model& model, const std::vector<AskedAcceleration>& asked) {
  std::vector<Prescribed> coordinates;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    for (const NamedCoordinate& named : named_coordinates(*joint.type)) {
      if (joint.start.at(named.word).role_u != StartRole::keep) continue;
      if (driver_of(joint, named.word, named.component) != nullptr) continue;
      if (named.kind == joints::CoordinateKind::orientation) {
        refuse(model, joint, "it keeps a ball, which no driver can move: keep coordinates that turn or slide instead");
      }
      const auto found = std::find_if(asked.begin(), asked.end(), [&](const AskedAcceleration& one) {
        return one.joint == joint.name && one.coordinate == named.name;
      });
      coordinates.push_back(
          {static_cast<int>(k), named.word, named.component, found != asked.end() ? found->value : 0.0});
    }
  }
  if (coordinates.empty()) {
    const bool is_driven = std::any_of(model.joints.begin(), model.joints.end(),
                                       [](const Joint& joint) { return !joint.drivers.empty(); });
    throw InputError({model.file, 0, 0},
                     is_driven ? "inverse: the model keeps no joint speed at its start, so that there is nothing to "
                                 "drive: drivers move it already; see `concord kinematics`"
                               : "inverse: the model keeps no joint speed at its start, so that there is nothing to "
                                 "drive: keep the coordinates and speeds that motors are to move");
  }
  check_asked(model, asked, coordinates);
  return coordinates;
}

Model driven_through(const Model& model, const State& state, const std::vector<Prescribed>& coordinates,
                     const std::function<bool(const Model&)>& starts) {
  Model driven = model;
  int surplus = 0;
  for (const Prescribed& one : coordinates) {
    Joint& joint = driven.joints[one.joint];
    const double q = state.q[one.joint](first_q(*joint.type, one.word) + one.component);
    const double u = state.u[one.joint](one.speed(model));
    joint.drivers.push_back({one.word, Polynomial{{q, u, 0.5 * one.acceleration}}, one.component});
    if (joint.start[one.word].role_q != StartRole::keep) ++surplus;
    joint.start[one.word].role_q = StartRole::unsaid;
    joint.start[one.word].role_u = StartRole::unsaid;
  }
  if (surplus == 0) return driven;
  return with_fewer_kept(driven, surplus, starts).value_or(driven);
}

double force_to_apply(const Model& model, const Evaluation& evaluation, const Prescribed& one) {
  const VecX of_couplings = coupled_tau(model, one.joint, evaluation.couplings);
  return evaluation.joints[one.joint].tau(one.speed(model)) - of_couplings(one.speed(model));
}

Model actuated_by(const Model& model, const Evaluation& evaluation, const std::vector<Prescribed>& coordinates) {
  Model actuated = model;
  for (const Prescribed& one : coordinates) {
    Joint& joint = actuated.joints[one.joint];
    std::erase_if(joint.springs, [&](const JointSpring& spring) {
      return spring.word == one.word && spring.component == one.component;
    });
    JointSpring motor;
    motor.word = one.word;
    motor.component = one.component;
    motor.law.actuator = ConstantSpeed{force_to_apply(model, evaluation, one), 0.0};
    joint.springs.push_back(std::move(motor));
  }
  return actuated;
}

}  // namespace concord::compare::analyses
