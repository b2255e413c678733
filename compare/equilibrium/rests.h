#pragma once

#include <array>

#include "common/model.h"
#include "common/results.h"
#include "compare/equilibrium/equilibrium.h"
#include "compare/states/branch.h"

/// The equilibria that both solvers find.
namespace concord::compare {

/// Digits that what each solver finds for itself must have in common: places of equilibrium, closed poses.
inline constexpr double kOwnRigid = 10.0;
inline constexpr double kOwnFlexible = 8.0;
/// One of these.
double own_need(const Model& model);

/// A trajectory of one state.
Trajectory one_sample(const State& state, const Evaluation& evaluation);

/// Equilibria by solver, and each as a trajectory of one state.
struct Rests {
  std::array<Equilibrium, 2> found;
  std::array<Trajectory, 2> states;
};
Rests find_rests(const Model& model, const Solvers& solvers);

/// Where two solvers found different rests: throws SolverError if each takes the other one's for a rest, too. Then the
/// machine has several, as where constraints hold for velocities alone, and the way to them, or round-off, chooses.
void refuse_undetermined_rest(const Model& model, const Solvers& solvers, const Rests& rests);

}  // namespace concord::compare
