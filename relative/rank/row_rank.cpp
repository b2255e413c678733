#include "relative/rank/row_rank.h"

#include <algorithm>
#include <cmath>

namespace concord::relative {

VecX inverse_iteration_start(int n) {
  VecX y(n);
  for (int i = 0; i < n; ++i) y(i) = 1.0 + 0.37 * std::sin(1.0 + 2.0 * i);
  return y.normalized();
}

void RowRank::compute(const MatX& Phi) {
  n_rows_ = Phi.rows();
  n_columns_ = Phi.cols();
  size_ = 1.0;
  rank_ = 0;
  if (Phi.size() == 0) return;
  qr_.compute(Phi.transpose());
  size_ = std::max(pivots().maxCoeff(), 1.0);
  rank_ = rank(kDependentPart);
}

int RowRank::rank(double part) const {
  if (n_rows_ == 0 || n_columns_ == 0) return 0;
  return static_cast<int>((pivots().array() > part * size_).count());
}

double RowRank::pivot(int place) const {
  return place < std::min(n_rows_, n_columns_) ? std::abs(qr_.matrixQR()(place, place)) / size_ : 0.0;
}

bool RowRank::is_beside_singular() const { return rank_ > 0 && relative_singular_value(rank_) <= kBesideSingular; }

MatX RowRank::vanishing_combinations(int rank) const {
  const Eigen::Index n_more = n_rows_ - rank;
  MatX combinations = MatX::Zero(n_rows_, n_more);
  combinations.bottomRows(n_more).setIdentity();
  if (rank == 0 || n_more == 0) return combinations;
  const auto R = qr_.matrixQR().topLeftCorner(rank, rank).triangularView<Eigen::Upper>();
  combinations.topRows(rank) = -R.solve(qr_.matrixQR().topRightCorner(rank, n_more));
  return orthonormal_columns(qr_.colsPermutation() * combinations);
}

MatX RowRank::free_directions() const {
  if (rank_ == 0) return MatX::Identity(n_columns_, n_columns_);
  return orthogonal_factor(qr_).rightCols(n_columns_ - rank_);
}

/// The direction y of the pivoted rows with the smallest |R y|, and that size, by inverse iteration (R70).
VecX RowRank::iterate(int rank, double& sigma) const {
  constexpr int kIterations = 4;
  const auto R = qr_.matrixQR().topLeftCorner(rank, rank).triangularView<Eigen::Upper>();
  VecX y = inverse_iteration_start(rank);
  sigma = 0.0;
  for (int round = 0; round < kIterations; ++round) {
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

double RowRank::singular_value(int rank) const {
  if (rank == 0) return 1.0;
  if (rank > std::min(n_rows_, n_columns_)) return 0.0;
  if (pivots().head(rank).minCoeff() == 0.0) return 0.0;
  double sigma = 0.0;
  (void)iterate(rank, sigma);
  return sigma;
}

VecX RowRank::weakest_combination(int rank) const {
  VecX rows = VecX::Zero(n_rows_);
  if (rank == 0 || n_rows_ == 0) return rows;
  const int n = static_cast<int>(std::min<Eigen::Index>({rank, n_rows_, n_columns_}));
  const auto& place = qr_.colsPermutation().indices();
  if (n < rank || pivots().head(n).minCoeff() == 0.0) {
    Eigen::Index last = 0;
    if (n > 0) pivots().head(n).minCoeff(&last);
    rows(place(std::min<Eigen::Index>(n < rank ? n : last, n_rows_ - 1))) = 1.0;
    return rows;
  }
  double sigma = 0.0;
  const VecX y = iterate(n, sigma);
  for (int i = 0; i < n; ++i) rows(place(i)) = y(i);
  return rows;
}

VecX RowRank::smallest_step(const VecX& misfit) const {
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
