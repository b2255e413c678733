#include "cartesian/rank/row_selection.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "common/decompositions.h"

namespace concord::cartesian {

namespace {

/// The smallest singular value of an upper triangular matrix, and its right singular vector: what the combination of
/// columns with these weights leaves.
struct SmallestSingularValue {
  double value = HUGE_VAL;
  VecX vector;
};

/// By three rounds of inverse iteration; `solve` and `solve_transposed` apply the inverse in place.
template <class Solve, class SolveTransposed>
SmallestSingularValue estimate_smallest(Eigen::Index size, const Solve& solve,
                                        const SolveTransposed& solve_transposed) {
  SmallestSingularValue smallest;
  if (size == 0) return {0.0, VecX()};
  VecX x = VecX::NullaryExpr(size, [](Eigen::Index k) { return k % 3 == 1 ? -1.0 : 1.0; }).normalized();
  for (int round = 0; round < 3; ++round) {
    smallest.vector = x;
    solve_transposed(x);
    solve(x);
    const double growth = x.norm();
    if (!(growth > 0.0) || !std::isfinite(growth)) break;
    smallest.value = 1.0 / std::sqrt(growth);
    x /= growth;
    smallest.vector = x;
  }
  return smallest;
}

template <class Triangle>
void select_from(const Triangle& R, RowSelection& selection) {
  const Eigen::Index live = selection.live;
  const MatX R11 = R.topLeftCorner(live, live);
  const auto triangle = R11.template triangularView<Eigen::Upper>();
  selection.dependence = R.topRightCorner(live, R.cols() - live);
  // Eigen's triangular solver reads the first entry of an empty matrix too.
  if (selection.dependence.size() > 0) triangle.solveInPlace(selection.dependence);
  selection.smallest_live =
      estimate_smallest(
          live, [&](VecX& x) { triangle.solveInPlace(x); }, [&](VecX& x) { triangle.transpose().solveInPlace(x); })
          .value;
}

Eigen::Index count_live(const VecX& diagonal, double tolerance) {
  Eigen::Index live = 0;
  while (live < diagonal.size() && std::abs(diagonal(live)) > tolerance) ++live;
  return live;
}

/// The rows that go first are selected among themselves, the others by their parts independent of these.
RowSelection select_dense_in_order(const MatX& transposed, const std::vector<bool>& goes_first, double tolerance) {
  std::vector<Eigen::Index> first;
  std::vector<Eigen::Index> then;
  for (Eigen::Index row = 0; row < transposed.cols(); ++row) (goes_first[row] ? first : then).push_back(row);
  std::vector<Eigen::Index> order;
  const Eigen::Index live_first = pivot_columns(transposed(Eigen::all, first), tolerance, order);
  RowSelection selection;
  std::vector<Eigen::Index> left_over;
  for (std::size_t k = 0; k < order.size(); ++k) {
    (static_cast<Eigen::Index>(k) < live_first ? selection.order : left_over).push_back(first[order[k]]);
  }
  const Eigen::HouseholderQR<MatX> qr_first(transposed(Eigen::all, selection.order));
  const MatX turned = apply_transposed_factor(qr_first, transposed(Eigen::all, then));
  const Eigen::Index live_then = pivot_columns(turned.bottomRows(turned.rows() - live_first), tolerance, order);
  for (std::size_t k = 0; k < order.size(); ++k) {
    (static_cast<Eigen::Index>(k) < live_then ? selection.order : left_over).push_back(then[order[k]]);
  }
  selection.live = live_first + live_then;
  selection.order.insert(selection.order.end(), left_over.begin(), left_over.end());
  const Eigen::HouseholderQR<MatX> qr(transposed(Eigen::all, selection.order));
  select_from(qr.matrixQR(), selection);
  return selection;
}

SmallestSingularValue smallest_of(const SparseMatrix& square) {
  const SparseMatrix square_transposed = square.transpose();
  const auto triangle = square.triangularView<Eigen::Upper>();
  const auto transposed_triangle = square_transposed.triangularView<Eigen::Lower>();
  return estimate_smallest(
      square.cols(), [&](VecX& x) { triangle.solveInPlace(x); }, [&](VecX& x) { transposed_triangle.solveInPlace(x); });
}

RowSelection select_sparse(const SparseMatrix& transposed, double tolerance) {
  SparseQr qr = sparse_qr(transposed, tolerance);
  RowSelection selection;
  selection.live = qr.rank;
  selection.order = std::move(qr.order);
  const SparseMatrix live_square = qr.R.topLeftCorner(selection.live, selection.live);
  const auto triangle = live_square.triangularView<Eigen::Upper>();
  selection.dependence = triangle.solve(MatX(qr.R.topRightCorner(selection.live, transposed.cols() - selection.live)));
  selection.smallest_live = smallest_of(live_square).value;
  return selection;
}

/// The columns `order[first]` to `order[first + count - 1]` of a matrix.
SparseMatrix columns_of(const SparseMatrix& matrix, const std::vector<Eigen::Index>& order, Eigen::Index first,
                        Eigen::Index count) {
  std::vector<Eigen::Triplet<double, SparseIndex>> entries;
  for (Eigen::Index k = 0; k < count; ++k) {
    for (SparseMatrix::InnerIterator entry(matrix, order[first + k]); entry; ++entry) {
      entries.emplace_back(entry.row(), k, entry.value());
    }
  }
  SparseMatrix columns(matrix.rows(), count);
  columns.setFromTriplets(entries.begin(), entries.end());
  return columns;
}

}  // namespace

Eigen::Index pivot_columns(const MatX& columns, double tolerance, std::vector<Eigen::Index>& order) {
  const Eigen::ColPivHouseholderQR<MatX> qr(columns);
  const auto indices = qr.colsPermutation().indices();
  order.assign(indices.begin(), indices.end());
  return count_live(qr.matrixQR().diagonal(), tolerance);
}

RowSelection select_dense(const MatX& transposed, double tolerance) {
  RowSelection selection;
  const Eigen::ColPivHouseholderQR<MatX> qr(transposed);
  const auto indices = qr.colsPermutation().indices();
  selection.order.assign(indices.begin(), indices.end());
  selection.live = count_live(qr.matrixQR().diagonal(), tolerance);
  select_from(qr.matrixQR(), selection);
  return selection;
}

RowSelection select_rows(const SparseMatrix& transposed, const std::vector<bool>* goes_first, double tolerance) {
  const Eigen::Index rows = transposed.cols();
  if (rows > kDenseRows) {
    RowSelection sparse = select_sparse(transposed, tolerance);
    const bool is_full = sparse.live == rows && sparse.smallest_live > tolerance;
    if (is_full || (rows > kMostDenseRows && goes_first == nullptr)) return sparse;
  }
  return goes_first != nullptr ? select_dense_in_order(MatX(transposed), *goes_first, tolerance)
                               : select_dense(MatX(transposed), tolerance);
}

void leave_over_dependent(const SparseMatrix& transposed, const std::vector<bool>* goes_first, double tolerance,
                          RowSelection& selection) {
  const Eigen::Index live_before = selection.live;
  while (selection.live > 0) {
    const SparseQr qr = sparse_qr(columns_of(transposed, selection.order, 0, selection.live), 0.0);
    if (qr.rank < selection.live) break;
    const SmallestSingularValue smallest = smallest_of(qr.R.topLeftCorner(selection.live, selection.live));
    selection.smallest_live = smallest.value;
    if (smallest.value > tolerance) break;
    Eigen::Index most = 0;
    double weight = -1.0;
    for (Eigen::Index k = 0; k < selection.live; ++k) {
      const Eigen::Index place = qr.order[k];
      const bool is_first = goes_first != nullptr && (*goes_first)[selection.order[place]];
      const double own = std::abs(smallest.vector(k)) * (is_first ? tolerance : 1.0);
      if (own > weight) std::tie(most, weight) = std::pair(place, own);
    }
    std::rotate(selection.order.begin() + most, selection.order.begin() + most + 1,
                selection.order.begin() + selection.live);
    --selection.live;
  }
  if (selection.live < live_before) express_left_over(transposed, selection);
}

void express_left_over(const SparseMatrix& transposed, RowSelection& selection) {
  const Eigen::Index left_over = transposed.cols() - selection.live;
  selection.dependence = sparse_least_squares(columns_of(transposed, selection.order, 0, selection.live),
                                              MatX(columns_of(transposed, selection.order, selection.live, left_over)));
}

}  // namespace concord::cartesian
