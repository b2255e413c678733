#pragma once

#include "common/solver.h"
#include "relative/start/assembly.h"
#include "relative/start/states.h"

/// Time integration with projection onto the closure after every step.
namespace concord::relative {

/// Names for RunOptions::integrator, the default for this model first: "adams" (explicit, multistep, with the ringing
/// of modes exact) and "dirk" (singly diagonally implicit Runge-Kutta of order 5 for stiff models, by SUNDIALS ARKODE).
std::vector<std::string> integrator_names(const Model& model);

/// Integrates from `start`, a closed state at t = 0, to options.until. At the output times the state is projected and
/// accelerations and wrenches are computed anew. Throws SolverError with time, place and reason.
Trajectory integrate(Equations& equations, Assembly& assembly, States& states, const Coordinates& start,
                     const RunOptions& options, const Progress& progress);

}  // namespace concord::relative
