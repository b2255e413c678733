#pragma once

#include <klu.h>

#include <vector>

#include "common/types.h"

namespace concord::cartesian {

/// Square sparse matrix of a frozen pattern (compressed columns, rows ascending) and its LU factors by KLU: symbolic
/// analysis once, numbers as often as they change. Structural zeros stay in the pattern.
class SparseLu {
 public:
  /// A symmetric pattern is ordered as it stands; any other first to block triangular form, which would spoil symmetry
  /// and with it sparse factors.
  enum class Pattern { general, symmetric };

  SparseLu(std::vector<int> column_starts, std::vector<int> row_indices, Pattern pattern = Pattern::general);
  ~SparseLu();
  SparseLu(const SparseLu&) = delete;
  SparseLu& operator=(const SparseLu&) = delete;

  [[nodiscard]] int size() const { return static_cast<int>(column_starts_.size()) - 1; }
  [[nodiscard]] double* values() { return values_.data(); }
  [[nodiscard]] const double* values() const { return values_.data(); }
  [[nodiscard]] const std::vector<int>& column_starts() const { return column_starts_; }
  [[nodiscard]] const std::vector<int>& row_indices() const { return row_indices_; }
  /// Place of entry (row, column) in values(); the entry must be in the pattern.
  [[nodiscard]] int find(int row, int column) const;

  /// Factorizes with new pivots. False if the matrix is singular.
  bool factor();
  /// Factorizes with the pivots of the last factor(); falls back to factor() if they are no longer good.
  bool refactor();
  /// Solves in place.
  void solve(VecX& x);
  /// Solves in place and improves the solution from its residual, twice at most, while that is above `good_enough` of
  /// the right side. False if the residual stays large.
  bool solve_refined(VecX& x, double good_enough);
  /// y -= matrix x.
  void subtract_product(const VecX& x, VecX& y) const;

 private:
  void write_residual(const VecX& x);

  std::vector<int> column_starts_;
  std::vector<int> row_indices_;
  std::vector<double> values_;
  klu_common common_{};
  klu_symbolic* symbolic_ = nullptr;
  klu_numeric* numeric_ = nullptr;
  VecX right_side_;
  VecX residual_;
};

}  // namespace concord::cartesian
