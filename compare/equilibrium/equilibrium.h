#pragma once

#include <vector>

#include "common/solver.h"
#include "compare/equilibrium/free_directions.h"

/// Static equilibrium, from a solver's accelerations alone.
namespace concord::compare {

/// The model at rest: drivers held where their laws are at t = 0, nothing moves at the start.
Model held_at_start(const Model& model);

struct Equilibrium {
  State state;
  Evaluation evaluation;
  int iterations = 0;
  /// Size of the last step in the chart's scaled coordinates.
  double last_step = 0.0;
  /// Of the equilibria along them the one nearest to the start is found.
  std::vector<FreeDirection> free;
  /// In so many directions the machine would leave the equilibrium.
  int unstable = 0;
  /// Size of Newton's next step, which was not made any more.
  double step_left = 0.0;
};

/// Finds the equilibrium to which the machine settles from the start. First pseudo-transient continuation: implicit
/// Euler steps along its accelerations, each ten times as long as the one before, motions that grow reversed (the sign
/// of positive eigenvalues of J). Where these steps have become short, Newton's method on the accelerations. Where
/// stiffness is missing (see StiffnessSplit), Newton's step leaves the direction alone; of the equilibria along such
/// directions the one nearest to the start in the joints' coordinates is found, by least squares. `model` must be
/// held_at_start() and `solver` made for it. Throws SolverError with the motion, and its sense, if nothing resists a
/// force along such a direction, or if no equilibrium is found; SingularPose where the pose is singular.
Equilibrium find_equilibrium(const Model& model, Solver& solver);
/// The same from a closed state at rest.
Equilibrium find_equilibrium(const Model& model, Solver& solver, const State& start);

}  // namespace concord::compare
