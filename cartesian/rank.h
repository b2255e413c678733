#pragma once

#include <Eigen/Sparse>
#include <vector>

#include "cartesian/equations.h"
#include "common/solver.h"

namespace concord::cartesian {

using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, SuiteSparse_long>;

/// Rank of a matrix with rows of unit size, and what its rows depend on each other by.
struct RankDecision {
  int rank = 0;
  double smallest_kept = 0.0;  // relative to the largest
  double largest_dropped = 0.0;
  MatX left_null_space;           // Z, orthonormal columns: Z^T matrix = 0
  std::vector<bool> independent;  // a largest independent set of rows
};

/// Singular values by dense SVD up to 500 rows, above that the diagonal of a rank-revealing sparse QR (SuiteSparseQR);
/// threshold 1e-10 of the largest. Throws SolverError if an entry is no number.
RankDecision decide_rank(const SparseMatrix& matrix);

/// Shortest x with matrix x = right side, dependent rows left out: by SuiteSparseQR; where rows are dependent, it gives
/// a solution but not the shortest, so up to 500 rows a complete orthogonal decomposition does.
VecX solve_shortest(const SparseMatrix& matrix, const VecX& right_side);

/// The machine's units over Y: v by L, omega by 1, adot by the size that moves a joint by L.
VecX column_scales(const Equations& equations);

/// Norm of each constraint row over Y in units of `columns` at the last update of `equations`; a coupling's is the sum
/// of its terms' norms, so that one whose terms cancel is seen to be small.
VecX row_sizes(const Equations& equations, const VecX& columns);

/// The constraint Jacobian over Y at the last update of `equations`, scaled so that rank does not depend on units:
/// columns by column_scales, then rows by row_sizes.
struct ScaledJacobian {
  SparseMatrix matrix;
  VecX row_scale;  // matrix row = row_scale * Phi_Y row * column scales; 1 for a row of zeros
};
ScaledJacobian scaled_jacobian(const Equations& equations);

/// A largest independent set of the constraint rows at the last update of `equations`; of rows that depend on each
/// other those that hold for positions come before those that hold for velocities alone.
std::vector<bool> independent_rows(const Equations& equations);

/// Orthonormal columns over [v / length_scale; omega; adot] of all moving bodies (n_Y rows) that span what the rows
/// permit at the last update of `equations`, drivers at rest.
MatX permitted_velocities(const Equations& equations);

/// Rank, and which reaction components stay the same for all multipliers in the null space of Phi_Y^T.
RankReport report_rank(const Equations& equations);

}  // namespace concord::cartesian
