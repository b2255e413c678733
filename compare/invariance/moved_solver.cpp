#include "compare/invariance/moved_solver.h"

#include <stdexcept>

namespace concord::compare::invariance {

std::optional<State> MovedSolver::close(const State& guess) {
  std::optional<State> closed = solver_->close(change_.state(guess));
  if (!closed) return std::nullopt;
  return change_.back(std::move(*closed));
}

Evaluation MovedSolver::evaluate(const State& state) {
  return change_.evaluation(state, solver_->evaluate(change_.state(state)));
}

MatX MovedSolver::tangent(const State&) { throw std::logic_error("a moved solver has no tangent"); }

Trajectory MovedSolver::integrate(const RunOptions&, const Progress&) {
  throw std::logic_error("a moved solver does not run");
}

}  // namespace concord::compare::invariance
