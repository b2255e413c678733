#include <catch2/catch.hpp>
#include <string>
#include <utility>

#include "judged_machines.h"

/// Motions whose neighbours part exponentially: no two integrations of them agree for long.
namespace concord::verification {
namespace {

/// A double pendulum of two tilted rods, thrown hard enough to tumble.
Model tumbling_pendulum() {
  return parse_model(R"(format = 1
name = "tumbling_pendulum"
gravity = [0.0, -9.81, 0.0]

[[body]]
name = "upper"
mass = 1.3
center_of_mass = [0.31, 0.02, -0.05]
inertia = [0.02, 0.05, 0.06]

[[body]]
name = "lower"
mass = 0.8
center_of_mass = [0.27, -0.03, 0.04]
inertia = [0.01, 0.03, 0.035]

[[joint]]
name = "shoulder"
type = "revolute"
parent = { body = "ground", point = [0.1, 0.2, 0.0] }
child = { body = "upper", point = [0.0, 0.01, 0.02] }
start.turn_z = { keep = 2.1, keep_speed = 0.4 }

[[joint]]
name = "elbow"
type = "revolute"
parent = { body = "upper", point = [0.62, 0.0, -0.03] }
child = { body = "lower", point = [0.0, -0.02, 0.0] }
start.turn_z = { keep = 0.9, keep_speed = -0.7 }

[run]
until = 14.0
)",
                     "tumbling_pendulum.toml");
}

/// A solver whose wrenches in runs are off by a part, while those in states that it is given are right.
class WrongInRuns : public Solver {
 public:
  WrongInRuns(std::unique_ptr<Solver> solver, double part) : solver_(std::move(solver)), part_(part) {}

  [[nodiscard]] std::string_view name() const override { return solver_->name(); }
  [[nodiscard]] std::vector<std::string> integrators() const override { return solver_->integrators(); }
  State assemble() override { return solver_->assemble(); }
  std::optional<State> close(const State& guess) override { return solver_->close(guess); }
  Evaluation evaluate(const State& state) override { return solver_->evaluate(state); }
  RankReport rank(const State& state) override { return solver_->rank(state); }
  MatX tangent(const State& state) override { return solver_->tangent(state); }
  Trajectory integrate(const RunOptions& options, const Progress& progress) override {
    Trajectory run = solver_->integrate(options, progress);
    for (Sample& sample : run.samples) {
      for (JointWrenches& joint : sample.evaluation.joints) {
        for (SideWrench& side : joint.reaction) side.in_C.force *= 1.0 + part_;
      }
    }
    return run;
  }

 private:
  std::unique_ptr<Solver> solver_;
  double part_;
};

compare::Verdict verdict_with_error(const Model& model, double part) {
  const auto cartesian_solver = cartesian::make_solver(model);
  WrongInRuns relative_solver(relative::make_solver(model), part);
  compare::VerifyOptions options;
  options.samples = 140;
  options.states = 40;
  return compare::verify(model, *cartesian_solver, relative_solver, options);
}

}  // namespace

TEST_CASE("A chaotic motion is judged up to the horizon that both solvers see alone", "[sensitive]") {
  const Model model = tumbling_pendulum();
  const compare::Verdict verdict = verdict_with_error(model, 0.0);
  INFO(compare::format_verdict(model, verdict, false));
  CHECK(verdict.outcome == compare::Outcome::agree);
  REQUIRE(verdict.same_run.horizon.has_value());
  CHECK(*verdict.same_run.horizon > 1.0);
  CHECK(*verdict.same_run.horizon < 13.0);
  CHECK(verdict.same_run.samples < 141);
  CHECK(verdict.same_state.passed);
}

TEST_CASE("Within the horizon a wrong reaction in runs is a difference", "[sensitive]") {
  const Model model = tumbling_pendulum();
  const compare::Verdict verdict = verdict_with_error(model, 1e-6);
  INFO(compare::format_verdict(model, verdict, false));
  CHECK(verdict.outcome == compare::Outcome::differ);
}

}  // namespace concord::verification
