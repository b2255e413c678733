#pragma once

#include <string>
#include <vector>

#include "cartesian/dynamics/dynamics.h"
#include "cartesian/rank/constraint_rank.h"
#include "common/results.h"
#include "common/solver.h"

/// A run: the motion of a machine from its start, step by step, and what is reported at the outputs.
namespace concord::cartesian {

/// Names of the integrators, the default first.
std::vector<std::string> integrator_names();

/// Integrates from `start` as the options say. Throws what Solver::integrate() does.
Trajectory run(Dynamics& dynamics, const MachineRank& machine, const State& start, const RunOptions& options,
               const Progress& progress);

}  // namespace concord::cartesian
