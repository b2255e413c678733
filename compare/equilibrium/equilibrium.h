#pragma once

#include <vector>

#include "common/solver.h"
#include "compare/equilibrium/free_directions.h"
#include "compare/equilibrium/stiffness.h"

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

/// Finds the equilibrium to which the machine settles from the start, by pseudo-transient continuation: implicit Euler
/// steps along its accelerations, each ten times as long, then Newton's method on the accelerations. Along motions that
/// grow the long steps go down as far as the curvature says, so that they neither jump nor crawl; how far a step goes
/// is StepLimit's. Stiff modes and soft rigid motions do not disturb each other: the modes are eliminated first. Where
/// stiffness is missing (see StiffnessSplit), the step of least norm leaves the direction alone, and StepsBack leads to
/// the rest nearest to the start. `model` must be held_at_start() and `solver` made for it. Throws SolverError if
/// nothing resists a force along such a direction, or if no equilibrium is found, saying where and why.
Equilibrium find_equilibrium(const Model& model, Solver& solver);
/// The same from a closed state at rest.
Equilibrium find_equilibrium(const Model& model, Solver& solver, const State& start);

}  // namespace concord::compare
