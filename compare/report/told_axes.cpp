#include "compare/report/told_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/error.h"
#include "common/reading/spelling.h"
#include "compare/audit/places.h"
#include "compare/resolution/unique_part.h"

namespace concord::compare {

namespace {

/// R v, where what is unknown (NaN) counts only along axes of which it has a part.
Vec3 turned_known(const Mat3& R, const Vec3& v) {
  Vec3 told = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    for (int c = 0; c < 3; ++c) {
      if (std::isnan(v(c)) && std::abs(R(axis, c)) <= kNoPart) continue;
      told(axis) += R(axis, c) * v(c);
    }
  }
  return told;
}

}  // namespace

int told_axes(const Model& model, const std::string& name, const std::filesystem::path& file) {
  std::vector<std::string> names;
  for (const Body& body : model.bodies) names.push_back(body.name);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  if (name == "world") return 0;
  names.insert(names.begin(), "world");
  throw InputError({file.string(), 0, 0},
                   fmt::format("--axes: there is no body '{}': {} ('world' stands for global axes)", name,
                               suggestion(name, names, "axes")));
}

std::string words_of(const Model& model, std::optional<int> axes) {
  if (!axes) return "its joint frame";
  return *axes == 0 ? "global axes" : "the axes of body " + model.bodies[static_cast<std::size_t>(*axes)].name;
}

std::string prefix_of(const Model& model, std::optional<int> axes) {
  if (!axes) return "";
  return *axes == 0 ? "global." : fmt::format("in_{}.", model.bodies[static_cast<std::size_t>(*axes)].name);
}

Wrench told_wrench(const Attachment& end, const State& state, const Wrench& in_C, int axes) {
  const Mat3 A = rotation_of(state.bodies[static_cast<std::size_t>(axes)].p);
  const Mat3 R = A.transpose() * place(end, state.bodies[static_cast<std::size_t>(end.body)]).A_joint;
  return {turned_known(R, in_C.force), turned_known(R, in_C.torque)};
}

Trajectory told_run(const Model& model, Trajectory run, int axes) {
  for (auto& [state, evaluation, work] : run.samples) {
    const auto tell = [&, &of = state](const Attachment& end, SideWrench& wrench) {
      wrench.in_C = told_wrench(end, of, wrench.in_C, axes);
    };
    for (const Side side : kSides) {
      const auto at = static_cast<std::size_t>(index(side));
      for (std::size_t k = 0; k < model.joints.size(); ++k) {
        tell(model.joints[k].on(side), evaluation.joints[k].reaction[at]);
        tell(model.joints[k].on(side), evaluation.joints[k].total[at]);
      }
      for (std::size_t k = 0; k < model.elements.size(); ++k) {
        const Attachment* end = end_of(model.elements[k], side);
        if (end != nullptr) tell(*end, evaluation.elements[k].on[at]);
      }
    }
  }
  return run;
}

}  // namespace concord::compare
