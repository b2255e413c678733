#pragma once

#include "common/decompositions.h"
#include "common/types.h"

/// Which closure rows are independent in a pose, and how nearly they depend on each other: all that asks whether a pose
/// is singular asks here.
namespace concord::relative {

/// Rows depend on others where their size beside these is below this part of the largest row, or of 1, the size of a
/// row, if all vanish.
inline constexpr double kDependentPart = 1e-10;
/// Rows below this part are dependent as far as a closed pose tells: near a singular pose residuals vanish with the
/// square of the distance, so that closed poses are known to the root of round-off only.
inline constexpr double kBesideSingular = 3e-6;

/// A unit vector that no symmetry favours.
[[nodiscard]] VecX inverse_iteration_start(int n);

/// The closure rows of one pose, in machine units over the columns that may move, factored with pivoting: Phi^T P =
/// Q R.
class RowRank {
 public:
  RowRank() = default;
  explicit RowRank(const MatX& Phi) { compute(Phi); }

  /// Rows of Phi (n x columns).
  void compute(const MatX& Phi);

  /// Number of rows whose pivots are above `part` of the largest, or of 1.
  [[nodiscard]] int rank(double part = kDependentPart) const;
  [[nodiscard]] int n_rows() const { return static_cast<int>(n_rows_); }
  /// Pivot of row `place` of the elimination, as a part of the largest, or of 1; zero if there are fewer.
  [[nodiscard]] double pivot(int place) const;

  /// Size of the smallest of the first `rank` singular values, by inverse iteration on the pivoted rows; zero if there
  /// are fewer rows or columns, or fewer pivots that are not zero (R70).
  [[nodiscard]] double singular_value(int rank) const;
  /// The same as a part of the largest pivot, or of 1.
  [[nodiscard]] double relative_singular_value(int rank) const { return singular_value(rank) / size_; }
  /// Whether the rows that are independent are dependent but for round-off, so that this pose lies beside a singular
  /// one.
  [[nodiscard]] bool is_beside_singular() const;

  /// Multipliers (n numbers, of unit size) of the combination of rows that is nearest to zero among the first `rank`.
  [[nodiscard]] VecX weakest_combination(int rank) const;
  /// Orthonormal multipliers (n x (n - rank)) of the combinations of rows that vanish, `rank` of them being
  /// independent (R67).
  [[nodiscard]] MatX vanishing_combinations(int rank) const;
  /// Orthonormal directions (columns x (columns - rank)) that no row holds (R69).
  [[nodiscard]] MatX free_directions() const;

  /// The smallest step x (one number per column) with Phi x = -misfit in the independent rows; the others follow (R66).
  [[nodiscard]] VecX smallest_step(const VecX& misfit) const;

 private:
  [[nodiscard]] VecX iterate(int rank, double& sigma) const;
  [[nodiscard]] auto pivots() const { return qr_.matrixQR().diagonal().cwiseAbs(); }

  Eigen::ColPivHouseholderQR<MatX> qr_;
  Eigen::Index n_rows_ = 0;
  Eigen::Index n_columns_ = 0;
  double size_ = 1.0;
  int rank_ = 0;
};

}  // namespace concord::relative
