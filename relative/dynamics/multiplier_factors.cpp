#include "relative/dynamics/multiplier_factors.h"

#include <cmath>

namespace concord::relative {

void MultiplierFactors::lay_out(int rank, Eigen::Index n_stacked) {
  stacked_.setZero(n_stacked, rank);
  qr_ = Eigen::ColPivHouseholderQR<MatX>(n_stacked, rank);
  permuted_.setZero(rank);
}

double MultiplierFactors::factor(const IndependentRows& rows) {
  is_orthogonal_ = false;
  return cholesky_.factor(rows);
}

MultiplierFactors::LeastSine MultiplierFactors::factor_stacked() {
  is_orthogonal_ = true;
  qr_.compute(stacked_);
  const Eigen::Index least = stacked_.cols() - 1;
  const double pivot = stacked_.rows() < stacked_.cols() ? 0.0 : std::abs(qr_.matrixQR()(least, least));
  return {pivot, qr_.colsPermutation().indices()(least)};
}

void MultiplierFactors::solve(const IndependentRows& rows, VecX& right) const {
  const std::vector<RowIndex>& used = rows.rows;
  const auto n = static_cast<Eigen::Index>(used.size());
  for (Eigen::Index i = 0; i < n; ++i) right(i) *= rows.scale[used[i]];
  if (is_orthogonal_) {
    const auto& place = qr_.colsPermutation().indices();
    for (Eigen::Index i = 0; i < n; ++i) permuted_(i) = right(place(i));
    const auto R = qr_.matrixQR().topRows(n).triangularView<Eigen::Upper>();
    R.transpose().solveInPlace(permuted_);
    R.solveInPlace(permuted_);
    for (Eigen::Index i = 0; i < n; ++i) right(place(i)) = permuted_(i);
  } else {
    cholesky_.solve(right);
  }
  for (Eigen::Index i = 0; i < n; ++i) right(i) *= rows.scale[used[i]];
}

}  // namespace concord::relative
