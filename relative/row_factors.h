#pragma once

#include "common/decompositions.h"
#include "common/types.h"

namespace concord::relative {

/// The closure rows of one pose, in machine units over the columns that may move, factored with pivoting: Phi^T P = Q
/// R. Says which rows are independent there and how nearly they depend on each other.
class RowFactors {
 public:
  /// Rows of Phi (n x columns).
  void compute(const MatX& Phi);

  /// Number of pivots above 1e-10 of the largest, or of 1, the size of a row, if all vanish.
  [[nodiscard]] int rank() const { return rank_; }

  /// Size of the smallest of the first `rank` singular values, by inverse iteration on the pivoted rows; zero if there
  /// are fewer rows or columns, or fewer pivots that are not zero.
  [[nodiscard]] double singular_value(int rank) const;

  /// Multipliers (n numbers, of unit size) of the combination of rows that is nearest to zero among the first `rank`.
  [[nodiscard]] VecX weakest_combination(int rank) const;

  /// The smallest step x (one number per column) with Phi x = -misfit in the independent rows; the others follow (R66).
  [[nodiscard]] VecX smallest_step(const VecX& misfit) const;

 private:
  [[nodiscard]] VecX iterate(int rank, double& sigma) const;

  Eigen::ColPivHouseholderQR<MatX> qr_;
  Eigen::Index n_rows_ = 0;
  Eigen::Index n_columns_ = 0;
  int rank_ = 0;
};

}  // namespace concord::relative
