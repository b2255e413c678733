#include "compare/equilibrium/other_rests.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "common/error.h"
#include "compare/equilibrium/joint_changes.h"
#include "compare/equilibrium/stiffness.h"

namespace concord::compare {

namespace {

constexpr Search kOtherWay{.longest_step = 0.15, .lengthening = 4.0};

/// How far two rests are apart [rad, of the machine's length].
double distance(const Model& model, const Equilibrium& one, const Equilibrium& other) {
  const VecX moved = joint_displacements(model, one.state, other.state);
  return moved.size() > 0 ? moved.lpNorm<Eigen::Infinity>() : 0.0;
}

}  // namespace

void refuse_other_rest(const Model& model, Solver& solver, const Equilibrium& found) {
  constexpr double kSamePlace = 1e-11;
  std::vector<std::string> names;
  for (const Joint& joint : model.joints) {
    if (joint.type->nonholonomic_rows() > 0) names.push_back(joint.name);
  }
  if (names.empty() || found.iterations == 1) return;
  const Equilibrium other = search_equilibrium(model, solver, kOtherWay);
  const double apart = distance(model, found, other);
  if (apart <= std::max(kSamePlace, 10.0 * (found.last_step + other.last_step))) return;
  throw SolverError(fmt::format(
      "{}: statics: the equilibrium is not determined: {} restrict{} velocities alone, so that the rest hangs by the "
      "way to it; another way ends {:.2g} (rad, or of the machine's length) beside; start in the equilibrium that is "
      "meant",
      solver.name(), fmt::join(names, ", "), names.size() == 1 ? "s" : "", apart));
}

std::string other_rest_of_like_search(const Model& model, Solver& solver, const Equilibrium& found) {
  constexpr double kElsewhere = 1e-3;
  const std::pair<Search, const char*> searches[] = {
      {{.displacement = 1e-13, .seed = 1, .rough_differences = Sense::backward}, "that begins 1e-13 beside"},
      {{.displacement = 1e-9, .seed = 2}, "that begins 1e-9 beside"},
      {kOtherWay, "in shorter steps"}};
  for (const auto& [search, words] : searches) {
    const double apart = distance(model, found, search_equilibrium(model, solver, search));
    if (apart <= kElsewhere) continue;
    return fmt::format(
        "{}: the machine has several rests, and the statement does not say to which of them it comes: a search {} "
        "comes to one that is {:.2g} (rad, or of the machine's length) away; start nearer to the one that is meant",
        solver.name(), words, apart);
  }
  return "";
}

void refuse_undetermined_rest(const Model& model, const Solvers& solvers, const std::array<Equilibrium, 2>& found) {
  for (const Equilibrium& one : found) {
    if (!one.kink.empty()) throw SolverError("statics: " + rests_at_kink(one.kink));
  }
  for (std::size_t who = 0; who < solvers.size(); ++who) {
    refuse_other_rest(model, *solvers[who], found[who]);
    const std::string other = other_rest_of_like_search(model, *solvers[who], found[who]);
    if (!other.empty()) throw SolverError("statics: " + other);
  }
}

}  // namespace concord::compare
