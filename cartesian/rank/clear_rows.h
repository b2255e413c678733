#pragma once

#include "cartesian/rank/sparse_qr.h"

namespace concord::cartesian {

/// Whether rows of about unit size are clearly independent, by the factors J J^T = L D L^T in an order of little fill,
/// which cost less than a QR factorization of J^T. Squares lose digits where rows hardly differ: such rows are left to
/// that factorization, and so are steps over the rows.
class ClearRows {
 public:
  explicit ClearRows(const SparseMatrix& rows);

  /// Whether of each row more than a thousandth is independent of those before it, and the smallest singular value, by
  /// inverse iteration, is above 1e-4. Numbers that are not finite are not clear.
  [[nodiscard]] bool are_independent() const { return are_independent_; }
  /// Estimated, at most a little too large; of rows that are independent.
  [[nodiscard]] double smallest_singular_value() const { return smallest_singular_value_; }

 private:
  double smallest_singular_value_ = 0.0;
  bool are_independent_ = false;
};

/// Rows that were clear when they were last factorized: so are those that differ from them by less than a quarter of
/// their smallest singular value, because no singular value changes by more than the difference has (Weyl).
class RowsOnceClear {
 public:
  /// Whether these rows, which have the same pattern each time, are clear; factorizes those that are farther away.
  [[nodiscard]] bool are_independent(const SparseMatrix& rows);

 private:
  VecX values_;  // of the matrix
  double reach_ = 0.0;
};

}  // namespace concord::cartesian
