#include "relative/row_factors.h"

#include <algorithm>
#include <cmath>

namespace concord::relative {

namespace {

constexpr double kDependentPivot = 1e-10;

}  // namespace

void RowFactors::compute(const MatX& Phi) {
  n_rows_ = Phi.rows();
  n_columns_ = Phi.cols();
  rank_ = 0;
  if (Phi.size() == 0) return;
  qr_.compute(Phi.transpose());
  const auto pivots = qr_.matrixQR().diagonal().cwiseAbs();
  rank_ = static_cast<int>((pivots.array() > kDependentPivot * std::max(pivots.maxCoeff(), 1.0)).count());
}

/// The direction y of the pivoted rows with the smallest |R y|, and that size: inverse iteration from a vector that no
/// symmetry favours (R70).
VecX RowFactors::iterate(int rank, double& sigma) const {
  constexpr int kRounds = 4;
  const auto R = qr_.matrixQR().topLeftCorner(rank, rank).triangularView<Eigen::Upper>();
  VecX y(rank);
  for (int i = 0; i < rank; ++i) y(i) = 1.0 + 0.37 * std::sin(1.0 + 2.0 * i);
  y.normalize();
  sigma = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    VecX x = R.transpose().solve(y);
    if (!x.allFinite()) return y;
    x.normalize();
    y = R.solve(x);
    const double size = y.norm();
    if (!std::isfinite(size)) return x;
    sigma = 1.0 / size;
    y /= size;
  }
  return y;
}

double RowFactors::singular_value(int rank) const {
  if (rank == 0) return 1.0;
  if (rank > std::min(n_rows_, n_columns_)) return 0.0;
  if (qr_.matrixQR().diagonal().head(rank).cwiseAbs().minCoeff() == 0.0) return 0.0;
  double sigma = 0.0;
  (void)iterate(rank, sigma);
  return sigma;
}

VecX RowFactors::weakest_combination(int rank) const {
  VecX rows = VecX::Zero(n_rows_);
  if (rank == 0 || n_rows_ == 0) return rows;
  const int n = static_cast<int>(std::min<Eigen::Index>({rank, n_rows_, n_columns_}));
  const auto& place = qr_.colsPermutation().indices();
  if (n < rank || qr_.matrixQR().diagonal().head(n).cwiseAbs().minCoeff() == 0.0) {
    Eigen::Index last = 0;
    if (n > 0) qr_.matrixQR().diagonal().head(n).cwiseAbs().minCoeff(&last);
    rows(place(std::min<Eigen::Index>(n < rank ? n : last, n_rows_ - 1))) = 1.0;
    return rows;
  }
  double sigma = 0.0;
  const VecX y = iterate(n, sigma);
  for (int i = 0; i < n; ++i) rows(place(i)) = y(i);
  return rows;
}

VecX RowFactors::smallest_step(const VecX& misfit) const {
  VecX step = VecX::Zero(n_columns_);
  if (rank_ == 0) return step;
  const auto& place = qr_.colsPermutation().indices();
  const auto R = qr_.matrixQR().topLeftCorner(rank_, rank_);
  for (int r = 0; r < rank_; ++r) {
    step(r) = (-misfit(place(r)) - R.col(r).head(r).dot(step.head(r))) / R(r, r);
  }
  apply_orthogonal_factor(qr_, step);
  return step;
}

}  // namespace concord::relative
