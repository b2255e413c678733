#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "compare/invariance/change.h"

namespace concord::compare::invariance {

/// A solver that works on another description of the machine and speaks of the first one: states are led there, and
/// what it finds is led back. It runs nothing.
class MovedSolver final : public Solver {
 public:
  using Maker = std::function<std::unique_ptr<Solver>(const Model&)>;
  /// `model`: the second description.
  MovedSolver(Change change, Model model, const Maker& make)
      : change_(std::move(change)), model_(std::move(model)), solver_(make(model_)) {}

  [[nodiscard]] std::string_view name() const override { return solver_->name(); }
  [[nodiscard]] std::vector<std::string> integrators() const override { return {}; }
  State assemble() override { return change_.back(solver_->assemble()); }
  std::optional<State> close(const State& guess) override {
    std::optional<State> closed = solver_->close(change_.state(guess));
    return closed ? std::optional(change_.back(std::move(*closed))) : std::nullopt;
  }
  Evaluation evaluate(const State& state) override {
    return change_.evaluation(state, solver_->evaluate(change_.state(state)));
  }
  RankReport rank(const State& state) override { return change_.report(solver_->rank(change_.state(state))); }
  /// Throws std::logic_error: velocities of the second description are none of the first.
  MatX tangent(const State& /*state*/) override { throw std::logic_error("a moved solver has no tangent"); }
  /// Throws std::logic_error.
  Trajectory integrate(const RunOptions& /*options*/, const Progress& /*progress*/) override {
    throw std::logic_error("a moved solver does not run");
  }
  [[nodiscard]] std::vector<std::string> cut_joints() const override { return solver_->cut_joints(); }

 private:
  Change change_;
  Model model_;  // outlives the solver
  std::unique_ptr<Solver> solver_;
};

}  // namespace concord::compare::invariance
