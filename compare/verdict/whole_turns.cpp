#include "compare/verdict/whole_turns.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/joints/facts.h"

namespace concord::compare {

namespace {

/// Whether the resistance of a law depends on its coordinate, and not on the speed or the time alone.
bool reads_coordinate(const ForceLaw& law) {
  return law.stiffness != 0.0 || law.spring_table || law.lower || law.upper;
}

bool is_coupled(const Model& model, std::size_t joint, int word, int component) {
  const auto is_it = [&](const CouplingTerm& term) {
    return term.joint == static_cast<int>(joint) && term.word == word && term.component == component;
  };
  return std::any_of(model.couplings.begin(), model.couplings.end(), [&](const Coupling& coupling) {
    return std::any_of(coupling.terms.begin(), coupling.terms.end(), is_it);
  });
}

}  // namespace

bool whole_turns_change_nothing(const Model& model, std::size_t joint, int word, int component) {
  const Joint& its = model.joints[joint];
  const joints::StatedCoordinates stated =
      joints::stated_coordinates(its.type->permits[static_cast<std::size_t>(word)]);
  if (stated[component].kind != joints::CoordinateKind::angle || !stated[component].axis) return false;
  const bool is_sprung = std::any_of(its.springs.begin(), its.springs.end(), [&](const JointSpring& spring) {
    return spring.word == word && spring.component == component && reads_coordinate(spring.law);
  });
  return !is_sprung && driver_of(its, word, component) == nullptr && !is_coupled(model, joint, word, component);
}

double with_turns_of(double near, double angle) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  return angle + kTurn * std::round((near - angle) / kTurn);
}

}  // namespace concord::compare
