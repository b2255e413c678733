#pragma once

#include <vector>

#include "cartesian/bodies/indices.h"
#include "cartesian/dynamics/equations.h"
#include "cartesian/dynamics/sparse_lu.h"

namespace concord::cartesian {

/// The matrix of the equations of motion, [M  Phi_Y^T; Phi_Y  0], assembled into a frozen pattern, with its factors.
/// The pattern holds all constraint rows: those that take no part are rows of the identity.
class AugmentedMatrix {
 public:
  explicit AugmentedMatrix(const Equations& equations);

  /// Place of a constraint row among the unknowns [Ydot; lambda].
  [[nodiscard]] int index_of(RowIndex row) const { return n_Y_ + row.value; }
  [[nodiscard]] const SparseLu& lu() const { return lu_; }
  [[nodiscard]] SparseLu& lu() { return lu_; }

  /// Which constraint rows take part, by row. Factorize with new pivots afterwards.
  void use_rows(const std::vector<bool>& active);
  /// Writes its numbers at the last update of the equations, rows that take no part included.
  void fill(const Equations& equations);
  /// Adds K to the inertia of a body's modes.
  void add_to_modes(BodyIndex body, const MatX& K);

 private:
  void find_entries(const Equations& equations);

  int n_Y_;
  int n_rows_;
  SparseLu lu_;
  ByBody<MatX> mass_matrices_;
  /// Where blocks go in the matrix's values: of a body the first entry of each column of M; by block of rows and column
  /// of the body the first of the block's rows; by block and row the first of the body's entries in the row's column.
  ByBody<std::vector<int>> mass_entries_;
  std::vector<std::vector<int>> Phi_Y_entries_;
  std::vector<std::vector<int>> transposed_entries_;
};

}  // namespace concord::cartesian
