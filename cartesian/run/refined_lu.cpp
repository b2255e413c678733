#include "cartesian/run/refined_lu.h"

#include <sunmatrix/sunmatrix_sparse.h>

#include <algorithm>

namespace concord::cartesian {

using sundials::view;

RefinedLu::RefinedLu(const std::vector<int>& column_starts, const std::vector<int>& row_indices,
                     const sundials::Context& context)
    : lu_(column_starts, row_indices),
      handle_(sundials::require(SUNLinSolNewEmpty(context.get()), "SUNLinSolNewEmpty")) {
  handle_->content = this;
  handle_->ops->gettype = &RefinedLu::type;
  handle_->ops->setup = &RefinedLu::set_up;
  handle_->ops->solve = &RefinedLu::solve;
  handle_->ops->free = &RefinedLu::free;
}

RefinedLu& RefinedLu::of(SUNLinearSolver solver) { return *static_cast<RefinedLu*>(solver->content); }

SUNLinearSolver_Type RefinedLu::type(SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; }

int RefinedLu::set_up(SUNLinearSolver solver, SUNMatrix matrix) {
  SparseLu& lu = of(solver).lu_;
  std::copy_n(SUNSparseMatrix_Data(matrix), lu.row_indices().size(), lu.values());
  return lu.factor() ? 0 : 1;
}

int RefinedLu::solve(SUNLinearSolver solver, SUNMatrix, N_Vector x, N_Vector b, sunrealtype) {
  RefinedLu& self = of(solver);
  self.x_ = view(b);
  if (!self.lu_.solve_refined(self.x_, 1e-15)) return 1;
  view(x) = self.x_;
  return 0;
}

int RefinedLu::free(SUNLinearSolver solver) {
  SUNLinSolFreeEmpty(solver);
  return 0;
}

}  // namespace concord::cartesian
