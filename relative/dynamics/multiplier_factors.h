#pragma once

#include "common/decompositions.h"
#include "relative/dynamics/independent_rows.h"
#include "relative/dynamics/lambda_blocks.h"

/// Factors of Lambda = Phi_u Mbar^-1 Phi_u^T over its independent rows.
namespace concord::relative {

/// Cholesky's factor of Lambda, or where that loses digits the orthogonal factor of the stacked unit responses E,
/// Lambda = E^T E. Memory is laid out by lay_out().
class MultiplierFactors {
 public:
  /// Of this Lambda, which must outlive this object.
  explicit MultiplierFactors(const LambdaBlocks& Lambda) : cholesky_(Lambda) {}

  /// For so many independent rows and `n_stacked` unknowns on the paths.
  void lay_out(int rank, Eigen::Index n_stacked);

  /// Cholesky's factor of the rows, scaled to unit diagonal. Its least pivot: the square of the sine between a row and
  /// those before it, in the metric of the inverse inertia; zero where Lambda is not positive definite.
  [[nodiscard]] double factor(const IndependentRows& rows);

  /// What the orthogonal factor tells of the rows: its least pivot, a sine; and the place of that row among them.
  struct LeastSine {
    double pivot;
    int place;
  };
  /// Unit responses, scaled, a column for each row, to be filled before factor_stacked().
  [[nodiscard]] MatX& stacked() { return stacked_; }
  /// Takes the factor of the stacked responses in place of Cholesky's.
  [[nodiscard]] LeastSine factor_stacked();

  /// Lambda^-1 of the rows, in place, by whichever factor was taken last.
  void solve(const IndependentRows& rows, VecX& right) const;

 private:
  BlockCholesky cholesky_;
  MatX stacked_;  // Lambda = stacked^T stacked
  Eigen::ColPivHouseholderQR<MatX> qr_;
  bool is_orthogonal_ = false;  // whether qr_ is used instead of cholesky_
  mutable VecX permuted_;
};

}  // namespace concord::relative
