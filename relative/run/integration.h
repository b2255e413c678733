#pragma once

#include "common/solver.h"
#include "relative/start/assembly.h"
#include "relative/start/states.h"

/// Time integration with SUNDIALS ARKODE and projection onto the closure after every step.
namespace concord::relative {

/// Names for RunOptions::integrator, the default for this model first: "erk" (explicit Runge-Kutta, Prince and
/// Dormand's pair of orders 8 and 7) and "dirk" (singly diagonally implicit Runge-Kutta of order 5 for stiff models).
std::vector<std::string> integrator_names(const Model& model);

/// Integrates from `start`, a closed state at t = 0, to options.until. The integrator stops exactly at the output
/// times; there the state is projected and accelerations and wrenches are computed anew. Throws SolverError with time,
/// place and reason.
Trajectory integrate(Equations& equations, Assembly& assembly, States& states, const Coordinates& start,
                     const RunOptions& options, const Progress& progress);

}  // namespace concord::relative
