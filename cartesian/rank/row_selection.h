#pragma once

#include <vector>

#include "cartesian/rank/sparse_qr.h"

/// Which rows of a matrix are independent, by a rank-revealing QR factorization of its transpose.
namespace concord::cartesian {

/// Of more rows a sparse QR makes the factorization, as long as it leaves none over.
inline constexpr Eigen::Index kDenseRows = 60;
/// Of more rows it makes any.
inline constexpr Eigen::Index kMostDenseRows = 500;

/// Rows in the order in which a QR factorization of the transposed matrix takes them: `live` ones first, then those
/// that are left over. R11 over the live rows, and how the others depend on them: row = dependence^T live rows + rest.
struct RowSelection {
  Eigen::Index live = 0;
  std::vector<Eigen::Index> order;
  MatX dependence;             // live x left over
  double smallest_live = 0.0;  // estimate of the smallest singular value of the live rows
};

/// `tolerance`: what others leave of a row that is left over. Where some are, the factorization is a dense one with
/// column exchanges (up to kMostDenseRows), which gives well-conditioned live rows, most independent first; with
/// `goes_first` given, its rows come before all others.
RowSelection select_rows(const SparseMatrix& transposed, const std::vector<bool>* goes_first, double tolerance);

/// The same by column exchanges, of any size.
RowSelection select_dense(const MatX& transposed, double tolerance);

/// Rows may leave each other more than the tolerance one by one and yet depend on each other together, which a sparse
/// QR without column exchanges does not see: as long as they do, the one that has the largest part in it is left over,
/// of those that need not go first if there is one. (Chan, Rank revealing QR factorizations, 1987.)
void leave_over_dependent(const SparseMatrix& transposed, const std::vector<bool>* goes_first, double tolerance,
                          RowSelection& selection);

/// Sets `dependence` anew by least squares: a sparse QR that drops a row at its place does not know what later ones
/// explain of it.
void express_left_over(const SparseMatrix& transposed, RowSelection& selection);

/// Order of the columns of a matrix by column pivoting, those above the tolerance first; returns how many these are.
Eigen::Index pivot_columns(const MatX& columns, double tolerance, std::vector<Eigen::Index>& order);

}  // namespace concord::cartesian
