#pragma once

#include "common/solver.h"

/// Machines whose drivers leave no motion free.
namespace concord::compare::analyses {

/// Closes a fully driven machine at every output time (options.until, options.samples), and evaluates velocities,
/// accelerations and reactions there: no integration. Between two outputs it takes as many steps as it needs to follow
/// the motion: each state is predicted from the one before, and a step is halved where a body turns by more than a
/// radian, the ends of the step do not foresee each other, or two steps of half its length lead elsewhere, so that
/// branches and turns do not are attached by the outputs. `work` is left zero.
/// Throws InputError if a degree of freedom is left, naming their number, or if a joint constrains speeds, and
/// SolverError if the machine cannot be followed.
Trajectory run_kinematics(const Model& model, Solver& solver, const RunOptions& options);

}  // namespace concord::compare::analyses
