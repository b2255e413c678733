#include "cartesian/rank/clear_rows.h"

#include <cmath>

namespace concord::cartesian {

namespace {

constexpr double kLeastSquare = 1e-6;  // of the part of a row that is its own
constexpr double kLeastSingularValue = 1e-4;

}  // namespace

ClearRows::ClearRows(const SparseMatrix& rows) : rows_(rows), transposed_(rows.transpose()) {
  if (rows.rows() == 0 || rows.rows() > rows.cols()) return;
  const SparseMatrix squares = rows * transposed_;
  factors_.compute(squares);
  if (factors_.info() != Eigen::Success || !(factors_.vectorD().array() > kLeastSquare).all()) return;
  constexpr int kRounds = 4;
  VecX y = VecX::NullaryExpr(rows.rows(), [](Eigen::Index k) { return k % 3 == 1 ? -1.0 : 1.0; }).normalized();
  double growth = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    const VecX next = factors_.solve(y);
    growth = next.norm();
    y = next / growth;
  }
  are_independent_ = 1.0 > kLeastSingularValue * kLeastSingularValue * growth;
}

VecX ClearRows::shortest(const VecX& right_side) const { return transposed_ * factors_.solve(right_side); }

}  // namespace concord::cartesian
