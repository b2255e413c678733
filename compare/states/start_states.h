#pragma once

#include <array>
#include <vector>

#include "common/solver.h"
#include "compare/states/states.h"

/// States that are known without a run.
namespace concord::compare {

/// Both solvers' starts (row 0) and, where both find it, the closed state of each a short step later (row 1): predicted
/// by its own accelerations and closed, after `longest` [s] or as much less as keeps every body within a hundredth of
/// the machine's length and of a radian. Nothing if a start is missing.
std::vector<OwnedState> states_from_starts(const Model& model, const std::array<Solver*, 2>& solvers,
                                           const std::array<State, 2>& starts, double longest);

/// The samples that the states of one owner make with a solver's evaluation; without those that the solver refuses.
Trajectory samples_of(Who owner, Solver& solver, const std::vector<OwnedState>& states);

}  // namespace concord::compare
