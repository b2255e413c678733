#pragma once

#include <memory>
#include <vector>

#include "cartesian/dynamics/sparse_lu.h"
#include "common/sundials.h"

namespace concord::cartesian {

/// SparseLu as a linear solver of SUNDIALS: new pivots with every Jacobian, because c changes its entries by many
/// orders of magnitude, and solutions refined, because its rows mix them.
class RefinedLu {
 public:
  /// For matrices of one pattern in compressed columns. The SUNDIALS handle points to this object, which must stay in
  /// its place. Throws SolverError if the pattern is structurally singular.
  RefinedLu(const std::vector<int>& column_starts, const std::vector<int>& row_indices,
            const sundials::Context& context);
  RefinedLu(const RefinedLu&) = delete;
  RefinedLu& operator=(const RefinedLu&) = delete;

  [[nodiscard]] SUNLinearSolver get() const { return handle_.get(); }

 private:
  static RefinedLu& of(SUNLinearSolver solver);
  static SUNLinearSolver_Type type(SUNLinearSolver solver);
  static int set_up(SUNLinearSolver solver, SUNMatrix matrix);
  static int solve(SUNLinearSolver solver, SUNMatrix matrix, N_Vector x, N_Vector b, sunrealtype tolerance);
  static int free(SUNLinearSolver solver);

  SparseLu lu_;
  VecX x_;
  sundials::LinearSolver handle_;
};

}  // namespace concord::cartesian
