#pragma once

#include <climits>
#include <vector>

#include "cartesian/dynamics/dynamics.h"
#include "cartesian/dynamics/equations.h"
#include "cartesian/rank/clear_rows.h"
#include "cartesian/rank/closing.h"
#include "cartesian/rank/rank.h"
#include "common/results.h"

/// What rank the constraints of a machine have in a pose, whether that pose is singular, and which rows to use there.
namespace concord::cartesian {

/// The constraint Jacobian over Y at the last update of `equations`, scaled so that rank does not depend on units:
/// columns by the machine's units, then rows by their sizes.
struct ScaledJacobian {
  SparseMatrix matrix;
  VecX row_scale;  // matrix row = row_scale * Phi_Y row * units; 1 for a row of zeros
};
ScaledJacobian scaled_jacobian(const Equations& equations);  // (C49)

/// A largest independent set of the constraint rows at the last update of `equations`, and its size; of rows that
/// depend on each other those that hold for positions come before those that hold for velocities alone.
struct RowChoice {
  int rank = 0;
  std::vector<bool> independent;  // by row
};
/// `most`: of a pose that is not closed, where rows that depend on each other on the motion do not quite do so; at most
/// so many rows, those that are most independent. `before`: what is known of poses of the same machine.
RowChoice choose_rows(const Equations& equations, int most = INT_MAX, RowsOnceClear* before = nullptr);

/// Columns over [v / length_scale; omega; adot] of all moving bodies (n_Y rows) that span what the rows permit at the
/// last update of `equations`, drivers at rest; orthonormal with modal coordinates in their units (C52).
MatX permitted_velocities(const Equations& equations);

/// Whether the constraints of a model can depend on each other at all: it has couplings, or joints that close a loop.
bool may_lose_rank(const Model& model);

/// What holds for a machine as a whole, whatever its pose: the rank of its constraints where it is not singular, and
/// whether closing has to move modes.
struct MachineRank {
  int generic = 0;
  Modes closing_modes = Modes::kept;
};

/// The start alone may be a singular pose; so poses round about are looked at too, closed without drivers: those to
/// which no body turns far, and that are not nearly singular themselves where there are others.
MachineRank decide_for_the_machine(Equations& equations, const State& start);

/// Takes rows that are independent at the last update, whatever was in use before, and solves with them. `before`: what
/// is known of poses of the same machine. Throws
/// SingularPose where the rank is below the machine's, or where rows that depend on others contradict them.
const Solution& solve_with_independent_rows(Dynamics& dynamics, const MachineRank& machine,
                                            RowsOnceClear* before = nullptr);

}  // namespace concord::cartesian
