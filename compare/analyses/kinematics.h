#pragma once

#include "common/solver.h"

/// Machines whose drivers leave no motion free.
namespace concord::compare::analyses {

/// Closes a fully driven machine at every output time (options.until, options.samples), predicted from the time before,
/// and evaluates velocities, accelerations and reactions there: no integration. `work` is left zero. Throws InputError
/// if a degree of freedom is left, naming their number, and SolverError if the machine cannot be closed at a time.
Trajectory run_kinematics(const Model& model, Solver& solver, const RunOptions& options);

}  // namespace concord::compare::analyses
