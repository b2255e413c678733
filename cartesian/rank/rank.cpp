#include "cartesian/rank/rank.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "cartesian/rank/row_selection.h"
#include "cartesian/rank/sparse_qr.h"
#include "common/decompositions.h"
#include "common/error.h"

namespace concord::cartesian {

namespace {

/// Rows that others leave less than this of are candidates of the null space: far above every threshold, far below
/// what independent rows leave.
constexpr double kCandidate = 1e-6;

/// Largest singular value, by rounds of power iteration on the transposed matrix; a few per cent off.
double estimate_largest(const SparseMatrix& transposed) {
  VecX x = VecX::Ones(transposed.cols()).normalized();
  double largest = 0.0;
  for (int round = 0; round < 8; ++round) {
    const VecX image = transposed * x;
    largest = std::max(largest, image.norm());
    x = transposed.transpose() * image;
    const double size = x.norm();
    if (!(size > 0.0)) break;
    x /= size;
  }
  for (Eigen::Index row = 0; row < transposed.cols(); ++row) {
    largest = std::max(largest, transposed.col(row).norm());
  }
  return largest > 0.0 ? largest : 1.0;
}

/// By left-over row the combination of rows that is it without what the live rows explain of it.
MatX combinations_of(const RowSelection& selection) {
  const auto n = static_cast<Eigen::Index>(selection.order.size());
  MatX Z = MatX::Zero(n, n - selection.live);
  for (Eigen::Index column = 0; column < Z.cols(); ++column) {
    for (Eigen::Index k = 0; k < selection.live; ++k) Z(selection.order[k], column) = -selection.dependence(k, column);
    Z(selection.order[selection.live + column], column) = 1.0;
  }
  return Z;
}

/// The parts of the left-over rows that are independent of all others, and their singular values (C50).
void decide_left_over(const SparseMatrix& transposed, RowSelection& selection, double largest, RankDecision& decision) {
  constexpr double kSurelyDependent = 1e-2 * kRankThreshold / kEitherWay;
  const Eigen::Index left_over = transposed.cols() - selection.live;
  MatX Z = combinations_of(selection);
  if (!((transposed * Z).norm() <= kSurelyDependent * largest)) {
    express_left_over(transposed, selection);
    Z = combinations_of(selection);
  }
  const MatX rest = transposed * Z;
  Z = orthonormal_columns(Z);
  decision.near_values = VecX::Zero(left_over);
  const double bound = rest.norm() / largest;  // of all of them: Z had unit vectors on the left-over rows
  decision.near_null_space = Z;
  decision.largest_dropped = bound;
  Eigen::Index added = 0;
  if (!(bound <= kSurelyDependent)) {
    const Eigen::JacobiSVD<MatX> svd(MatX(transposed * Z), Eigen::ComputeFullV);
    VecX values = VecX::Zero(left_over);
    values.head(svd.singularValues().size()) = svd.singularValues() / largest;
    decision.near_values = values.reverse();
    decision.near_null_space = Z * svd.matrixV().rowwise().reverse();
    decision.largest_dropped = 0.0;
    for (const double value : values) {
      if (value > kRankThreshold) {
        ++added;
        decision.smallest_kept = std::min(decision.smallest_kept, value);
      } else {
        decision.largest_dropped = std::max(decision.largest_dropped, value);
      }
    }
  }
  std::vector<Eigen::Index> order(left_over);
  std::iota(order.begin(), order.end(), 0);
  if (added > 0) (void)pivot_columns(rest, 0.0, order);
  for (Eigen::Index k = 0; k < added; ++k) {
    decision.independent.push_back(selection.order[selection.live + order[k]]);
  }
  decision.rank += static_cast<int>(added);
  decision.left_null_space = decision.near_null_space.leftCols(left_over - added);
}

}  // namespace

RankDecision decide_rank(const SparseMatrix& matrix, const std::vector<bool>* goes_first) {
  RankDecision decision;
  if (matrix.rows() == 0) return decision;
  if (!Eigen::Map<const VecX>(matrix.valuePtr(), matrix.nonZeros()).allFinite()) {
    throw SolverError(
        "cartesian: the Jacobian of the constraints holds an entry that is not a number: its rank cannot be decided");
  }
  const SparseMatrix transposed = matrix.transpose();
  RowSelection selection = select_rows(transposed, goes_first, kCandidate);
  if (selection.smallest_live <= kCandidate) leave_over_dependent(transposed, goes_first, kCandidate, selection);
  const double largest = estimate_largest(transposed);
  decision.rank = static_cast<int>(selection.live);
  decision.smallest_kept = selection.smallest_live / largest;
  for (Eigen::Index k = 0; k < selection.live; ++k) decision.independent.push_back(selection.order[k]);
  decision.left_null_space = decision.near_null_space = MatX::Zero(matrix.rows(), 0);
  if (selection.live < matrix.rows()) decide_left_over(transposed, selection, largest, decision);
  return decision;
}

namespace {

constexpr double kDependent = 1e-8;  // rows that depend on others to this are left out of a Newton step

/// The shortest x with which a matrix of so many pivots, what is beyond them left out, comes closest to the right side.
VecX solve_truncated(const MatX& matrix, const VecX& right_side, Eigen::Index most_rank) {
  Eigen::ColPivHouseholderQR<MatX> rows(matrix.transpose());
  rows.setThreshold(kDependent);
  const Eigen::Index rank = std::min(rows.rank(), most_rank);
  if (rank == 0) return VecX::Zero(matrix.cols());
  const MatX pivots = rows.matrixR().topRows(rank).triangularView<Eigen::Upper>();
  VecX x = VecX::Zero(matrix.cols());
  x.head(rank) = least_squares(pivots.transpose(), rows.colsPermutation().transpose() * right_side);
  apply_orthogonal_factor(rows, x);
  return x;
}

}  // namespace

VecX solve_shortest(const SparseMatrix& matrix, const VecX& right_side, ShortestSolver& solver,
                    std::optional<int> most_rank) {
  const bool may_be_dense = matrix.rows() <= kMostDenseRows;
  if (may_be_dense && most_rank && *most_rank < matrix.rows()) {
    return solve_truncated(MatX(matrix), right_side, *most_rank);
  }
  ShortestSolution solution = solver.solve(matrix.transpose(), right_side, kDependent);
  const bool has_full_rank = solution.rank == matrix.rows();
  return has_full_rank || !may_be_dense ? std::move(solution.x)
                                        : solve_truncated(MatX(matrix), right_side, matrix.rows());
}

}  // namespace concord::cartesian
