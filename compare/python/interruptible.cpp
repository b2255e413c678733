#include "compare/python/interruptible.h"

#include "cartesian/solver.h"
#include "common/open_evaluation.h"
#include "relative/solver.h"

namespace concord::compare::python {

namespace {

/// A solver that looks at the flag whenever it is called.
class StoppableSolver : public Solver, public OpenEvaluation {
 public:
  StoppableSolver(std::unique_ptr<Solver> solver, const StopFlag& stop)
      : solver_(std::move(solver)), open_(dynamic_cast<OpenEvaluation&>(*solver_)), stop_(stop) {}

  [[nodiscard]] std::string_view name() const override { return solver_->name(); }
  [[nodiscard]] std::vector<std::string> integrators() const override { return solver_->integrators(); }
  [[nodiscard]] std::vector<std::string> cut_joints() const override { return solver_->cut_joints(); }

  State assemble() override {
    check(stop_);
    return solver_->assemble();
  }
  std::optional<State> close(const State& guess) override {
    check(stop_);
    return solver_->close(guess);
  }
  Evaluation evaluate(const State& state) override {
    check(stop_);
    return solver_->evaluate(state);
  }
  Evaluation evaluate_open(const State& state) override {
    check(stop_);
    return open_.evaluate_open(state);
  }
  RankReport rank(const State& state) override {
    check(stop_);
    return solver_->rank(state);
  }
  MatX tangent(const State& state) override {
    check(stop_);
    return solver_->tangent(state);
  }
  Trajectory integrate(const RunOptions& options, const Progress& progress) override {
    return solver_->integrate(options, [&](double t) {
      check(stop_);
      if (progress) progress(t);
    });
  }

 private:
  std::unique_ptr<Solver> solver_;
  OpenEvaluation& open_;  // of the same solver
  const StopFlag& stop_;
};

}  // namespace

void check(const StopFlag& stop) {
  if (stop) throw Stopped{};
}

SolverMakers stoppable_makers(const StopFlag& stop) {
  return {[&stop](const Model& model) -> std::unique_ptr<Solver> {
            return std::make_unique<StoppableSolver>(cartesian::make_solver(model), stop);
          },
          [&stop](const Model& model) -> std::unique_ptr<Solver> {
            return std::make_unique<StoppableSolver>(relative::make_solver(model), stop);
          }};
}

std::optional<py::error_already_set> pending_signal() {
  if (PyErr_CheckSignals() == 0) return std::nullopt;
  return std::optional<py::error_already_set>(std::in_place);
}

}  // namespace concord::compare::python
