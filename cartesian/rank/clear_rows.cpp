#include "cartesian/rank/clear_rows.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <utility>
#include <vector>

namespace concord::cartesian {

namespace {

constexpr double kLeastSquare = 1e-6;  // of the part of a row that is its own
constexpr double kLeastSingularValue = 1e-4;

/// J J^T, of which the factorization reads the lower triangle alone, in no order within a column.
SparseMatrix lower_squares(const SparseMatrix& rows, const SparseMatrix& transposed) {
  const Eigen::Index n = rows.rows();
  SparseMatrix squares(n, n);
  squares.reserve(4 * rows.nonZeros());
  VecX sums = VecX::Zero(n);
  std::vector<Eigen::Index> last_seen_by(n, -1);
  std::vector<Eigen::Index> others;
  for (Eigen::Index row = 0; row < n; ++row) {
    others.clear();
    for (SparseMatrix::InnerIterator own(transposed, row); own; ++own) {
      for (SparseMatrix::InnerIterator other(rows, own.row()); other; ++other) {
        if (other.row() < row) continue;
        if (std::exchange(last_seen_by[other.row()], row) != row) others.push_back(other.row());
        sums(other.row()) += own.value() * other.value();
      }
    }
    squares.startVec(row);
    for (const Eigen::Index other : others) {
      squares.insertBackByOuterInnerUnordered(row, other) = std::exchange(sums(other), 0.0);
    }
  }
  squares.finalize();
  return squares;
}

}  // namespace

ClearRows::ClearRows(const SparseMatrix& rows) {
  if (rows.rows() == 0 || rows.rows() > rows.cols()) return;
  const Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::AMDOrdering<SparseIndex>> factors(
      lower_squares(rows, rows.transpose()));
  if (factors.info() != Eigen::Success || !(factors.vectorD().array() > kLeastSquare).all()) return;
  constexpr int kRounds = 4;
  VecX y = VecX::NullaryExpr(rows.rows(), [](Eigen::Index k) { return k % 3 == 1 ? -1.0 : 1.0; }).normalized();
  double growth = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    const VecX next = factors.solve(y);
    growth = next.norm();
    y = next / growth;
  }
  smallest_singular_value_ = 1.0 / std::sqrt(growth);
  are_independent_ = smallest_singular_value_ > kLeastSingularValue;
}

bool RowsOnceClear::are_independent(const SparseMatrix& rows) {
  constexpr double kReach = 0.25;
  const Eigen::Map<const VecX> values(rows.valuePtr(), rows.nonZeros());
  if (values.size() == values_.size() && (values - values_).norm() < reach_) return true;
  const ClearRows clear(rows);
  if (!clear.are_independent()) return false;
  values_ = values;
  reach_ = kReach * clear.smallest_singular_value();
  return true;
}

}  // namespace concord::cartesian
