#pragma once

#include <vector>

#include "cartesian/equations.h"
#include "cartesian/row_selection.h"

/// Which constraint rows of a machine are independent, and what they permit.
namespace concord::cartesian {

/// The constraint Jacobian over Y at the last update of `equations`, scaled so that rank does not depend on units:
/// columns by the machine's units, then rows by their sizes.
struct ScaledJacobian {
  SparseMatrix matrix;
  VecX row_scale;  // matrix row = row_scale * Phi_Y row * units; 1 for a row of zeros
};
ScaledJacobian scaled_jacobian(const Equations& equations);  // (C49)

/// A largest independent set of the constraint rows at the last update of `equations`, and its size; of rows that
/// depend on each other those that hold for positions come before those that hold for velocities alone. Where
/// `expected` rows are well independent no other rank is looked for.
struct RowChoice {
  int rank = 0;
  std::vector<bool> independent;
};
RowChoice choose_rows(const Equations& equations, int expected);
/// The same of a pose that is not closed, where rows that depend on each other on the motion do not quite do so: at
/// most `expected` rows, those that are most independent.
RowChoice choose_rows_beside(const Equations& equations, int expected);
std::vector<bool> independent_rows(const Equations& equations);

/// Columns over [v / length_scale; omega; adot] of all moving bodies (n_Y rows) that span what the rows permit at the
/// last update of `equations`, drivers at rest; orthonormal with modal coordinates in their units (C52).
MatX permitted_velocities(const Equations& equations);

}  // namespace concord::cartesian
