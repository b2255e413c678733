#pragma once

#include <Eigen/SparseCholesky>

#include "cartesian/rank/sparse_qr.h"

namespace concord::cartesian {

/// Rows of about unit size that are clearly independent, and the factors J J^T = L D L^T in an order of little fill,
/// which cost a tenth of a QR factorization of J^T. Squares lose digits where rows hardly differ: such rows are left to
/// that factorization.
class ClearRows {
 public:
  explicit ClearRows(const SparseMatrix& rows);

  /// Whether of each row more than a thousandth is independent of those before it, and the smallest singular value, by
  /// inverse iteration, is above 1e-4. Numbers that are not finite are not clear.
  [[nodiscard]] bool are_independent() const { return are_independent_; }
  /// The shortest x with J x = right side, J^T (J J^T)^-1 right side, where the rows are independent.
  [[nodiscard]] VecX shortest(const VecX& right_side) const;

 private:
  const SparseMatrix& rows_;
  SparseMatrix transposed_;
  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::AMDOrdering<SparseIndex>> factors_;
  bool are_independent_ = false;
};

}  // namespace concord::cartesian
