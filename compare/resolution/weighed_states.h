#pragma once

#include <array>
#include <string>
#include <vector>

#include "compare/resolution/open_reactions.h"
#include "compare/resolution/resolution.h"
#include "compare/resolution/uniqueness.h"

/// States that both solvers evaluated, with all that a difference there is compared with.
namespace concord::compare {

struct WeighedStates {
  std::vector<SharedState> states;
  Series series;
  RankReports reports;
  /// Where each quantity is unique.
  Mask mask;
  /// In which directions reactions are not unique.
  OpenReactions open;
  Resolution resolution;
  SingularPoses poses;
  /// Of each state why it is singular, by its rank or within round-off, so that nothing is judged there; empty for all
  /// others.
  std::vector<std::string> singular;
  /// Where the solvers say different things of rank and uniqueness.
  std::vector<Finding> findings;
  /// Why states were dropped, because a solver could not find its rank there; empty if none was.
  std::string dropped;
  /// Number of perturbed states left out because they are beside a singular pose.
  int beside_singular = 0;

  [[nodiscard]] Budget budget() const { return {&resolution.both, &mask}; }
};

/// Asks both solvers in every state for rank and resolution. Throws IncompleteResult like align().
WeighedStates weigh(const QuantityLayout& layout, const std::array<Solver*, 2>& solvers,
                    std::vector<SharedState> states, std::uint64_t seed);

/// Uniqueness and resolution in the samples of a run from which the states were taken.
struct WeighedRun {
  Mask mask;
  MatX resolution;

  [[nodiscard]] Budget budget() const { return {&resolution, &mask}; }
};
WeighedRun weigh_run(const WeighedStates& weighed, int samples);

}  // namespace concord::compare
