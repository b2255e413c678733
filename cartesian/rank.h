#pragma once

#include <Eigen/Sparse>
#include <cstdint>
#include <vector>

#include "cartesian/equations.h"
#include "common/solver.h"

namespace concord::cartesian {

/// Indices as SuiteSparse has them.
using SparseIndex = std::int64_t;
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, SparseIndex>;

/// Rank of a matrix with rows of unit size, and what its rows depend on each other by. Values are relative to the
/// largest singular value.
struct RankDecision {
  int rank = 0;
  double smallest_kept = 0.0;
  double largest_dropped = 0.0;
  MatX left_null_space;           // Z, orthonormal columns: Z^T matrix = 0
  std::vector<bool> independent;  // a largest independent set of rows
  /// The left singular vectors of all small singular values, those of the null space and any that another threshold
  /// would add to it, by rising value.
  MatX near_null_space;
  VecX near_values;
};

/// Threshold 1e-10 of the largest singular value. Singular values that small are found exactly, from the rows that a
/// rank-revealing QR leaves over (dense with pivots up to 60 rows, sparse by SuiteSparseQR above); the smallest of the
/// others and the largest are estimated. With `goes_first` given, its rows come before all others into the independent
/// set, and the QR is a dense one. Throws SolverError if an entry is no number.
RankDecision decide_rank(const SparseMatrix& matrix, const std::vector<bool>* goes_first = nullptr);

/// Shortest x with matrix x = right side, dependent rows left out: by SuiteSparseQR; where rows are dependent, it gives
/// a solution but not the shortest, so up to 500 rows a complete orthogonal decomposition does. Rows should be of about
/// unit size.
VecX solve_shortest(const SparseMatrix& matrix, const VecX& right_side);

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

/// Orthonormal columns over [v / length_scale; omega; adot] of all moving bodies (n_Y rows) that span what the rows
/// permit at the last update of `equations`, drivers at rest (C52).
MatX permitted_velocities(const Equations& equations);

/// Rank, and which reaction components, coordinate forces and coupling forces stay the same for all multipliers in the
/// null space of Phi_Y^T; which of these answers another threshold would change.
RankReport report_rank(const Equations& equations);

}  // namespace concord::cartesian
