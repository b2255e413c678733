#pragma once

#include <optional>
#include <vector>

#include "cartesian/rank/row_selection.h"
#include "cartesian/rank/sparse_qr.h"

/// The rank of a matrix, and its null space.
namespace concord::cartesian {

/// Singular values up to this, relative to the largest, count as zero.
inline constexpr double kRankThreshold = 1e-10;
/// The factor by which a threshold is moved, up and down, to see whether an answer depends on it.
inline constexpr double kEitherWay = 31.622776601683793;

/// Rank of a matrix with rows of unit size, and what its rows depend on each other by. Values are relative to the
/// largest singular value.
struct RankDecision {
  int rank = 0;
  double smallest_kept = 0.0;
  double largest_dropped = 0.0;
  MatX left_null_space;                   // Z, orthonormal columns: Z^T matrix = 0
  std::vector<Eigen::Index> independent;  // a largest independent set of rows, up to 500 rows the most so first
  /// The left singular vectors of all small singular values, those of the null space and any that another threshold
  /// would add to it, by rising value.
  MatX near_null_space;
  VecX near_values;
};

/// Threshold 1e-10 of the largest singular value. Singular values that small are found exactly, from the rows that a
/// rank-revealing QR leaves over (select_rows); the smallest of the others and the largest are estimated. With
/// `goes_first` given, its rows come before all others into the independent set. Throws SolverError if an entry is no
/// number.
RankDecision decide_rank(const SparseMatrix& matrix, const std::vector<bool>* goes_first = nullptr);

/// Shortest x with matrix x = right side, dependent rows left out: by a sparse QR; where rows are dependent, that
/// gives a solution but not the shortest, so up to 500 rows a dense QR with column exchanges does. Rows should be of
/// about unit size. `most_rank`: that of the matrix where the right side vanishes. Up to 500 rows, what it has beyond
/// as many pivots is left out, and the rows are obeyed by least squares: it comes from the right side and would ask for
/// steps as large as this is small. `solver`: that of the matrices before.
VecX solve_shortest(const SparseMatrix& matrix, const VecX& right_side, ShortestSolver& solver,
                    std::optional<int> most_rank = {});

}  // namespace concord::cartesian
