#pragma once

#include "common/types.h"

namespace concord::relative {

/// Up to three columns c in three dimensions and an orthonormal basis whose first directions span them: c = Q R with R
/// upper triangular (Gram and Schmidt, twice for round-off). No heap memory, no iteration.
class SpatialBasis {
 public:
  /// Takes the first n columns, n = 0 .. 3. A column that depends on those before it, to 1e-9 of its length, gets no
  /// part in a fit.
  void decompose(const Mat3& columns, int n);

  /// The n numbers x with which the columns' sum comes closest to v, |C x - v| least; zeros behind them.
  [[nodiscard]] Vec3 fit(const Vec3& v) const;

  [[nodiscard]] int n() const { return n_; }
  /// The 3 - n directions at right angles to all columns.
  [[nodiscard]] auto complement() const { return Q_.rightCols(3 - n_); }

 private:
  void add(const Vec3& column, int place);

  Mat3 Q_ = Mat3::Identity();
  Mat3 R_ = Mat3::Zero();
  Vec3 one_over_pivot_ = Vec3::Zero();  // zero for a dependent column
  int n_ = 0;
};

/// What the last of the first n columns keeps beside the others, the longest taken first; infinite if n = 0.
double least_independent_part(const Mat3& columns, int n);

}  // namespace concord::relative
