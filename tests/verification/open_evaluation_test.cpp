#include "common/open_evaluation.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cartesian/solver.h"
#include "common/reading/model_file.h"
#include "compare/equilibrium/equilibrium.h"
#include "compare/states/chart.h"
#include "relative/solver.h"

/// Derivatives of accelerations from states that are open in second order.
namespace {

using namespace concord;

Model machine(const std::string& name) {
  return compare::held_at_start(read_model(std::filesystem::path(CONCORD_DATA) / "models" / (name + ".toml")));
}

std::unique_ptr<Solver> solver_by(const std::string& who, const Model& model) {
  return who == "cartesian" ? cartesian::make_solver(model) : relative::make_solver(model);
}

/// A solver that counts how often it closes, and evaluates open states as the one behind it.
class Counting : public Solver, public OpenEvaluation {
 public:
  explicit Counting(std::unique_ptr<Solver> solver) : solver_(std::move(solver)) {}

  int closings = 0;

  [[nodiscard]] std::string_view name() const override { return solver_->name(); }
  [[nodiscard]] std::vector<std::string> integrators() const override { return solver_->integrators(); }
  State assemble() override { return solver_->assemble(); }
  std::optional<State> close(const State& guess) override {
    ++closings;
    return solver_->close(guess);
  }
  Evaluation evaluate(const State& state) override { return solver_->evaluate(state); }
  Evaluation evaluate_open(const State& state) override {
    return dynamic_cast<OpenEvaluation&>(*solver_).evaluate_open(state);
  }
  RankReport rank(const State& state) override { return solver_->rank(state); }
  MatX tangent(const State& state) override { return solver_->tangent(state); }
  Trajectory integrate(const RunOptions& options, const Progress& progress) override {
    return solver_->integrate(options, progress);
  }

 private:
  std::unique_ptr<Solver> solver_;
};

}  // namespace

TEST_CASE("To first order accelerations in open states are those of the closed states beside them", "[quick]") {
  const std::string name = GENERATE(as<std::string>{}, "car", "slider_crank_redundant", "four_bar_with_rod",
                                    "springs_in_a_loop", "loads_on_flexible_bodies", "flexible_frame_on_springs");
  const std::string who = GENERATE(as<std::string>{}, "cartesian", "relative");
  INFO(name << " by " << who);
  const Model model = machine(name);
  const auto solver = solver_by(who, model);
  auto& open = dynamic_cast<OpenEvaluation&>(*solver);
  const compare::Chart chart(model, *solver, solver->assemble());
  const VecX direction = VecX::LinSpaced(chart.n(), 1.0, 2.0).normalized();
  const auto slope = [&](bool closes, double h) {
    const auto at = [&](double way) -> VecX {
      if (!closes) {
        const State state = chart.moved_by(way * direction);
        return chart.accelerations(state, open.evaluate_open(state));
      }
      const State state = chart.place_at(way * direction).value();
      return chart.accelerations(state, solver->evaluate(state));
    };
    return VecX((at(h) - at(-h)) / (2.0 * h));
  };
  constexpr double kStep = 1e-4;
  const VecX closed = (4.0 * slope(true, 0.5 * kStep) - slope(true, kStep)) / 3.0;
  const VecX opened = (4.0 * slope(false, 0.5 * kStep) - slope(false, kStep)) / 3.0;
  CHECK((opened - closed).norm() <= 1e-6 * closed.norm());
}

TEST_CASE("Both solvers name the directions without stiffness of a rest in the same order", "[quick]") {
  const Model model = machine("car");
  const auto names = [&](const std::string& who) {
    std::vector<std::string> found;
    for (const compare::FreeDirection& direction : compare::find_equilibrium(model, *solver_by(who, model)).free) {
      found.push_back(direction.name);
    }
    return found;
  };
  const std::vector<std::string> by_cartesian = names("cartesian");
  CHECK(by_cartesian.size() == 7);
  CHECK(names("relative") == by_cartesian);
}

TEST_CASE("A car on its tires is not put back to where it starts, for their stiffness tells where it rests",
          "[quick]") {
  const std::string who = GENERATE(as<std::string>{}, "cartesian", "relative");
  const Model model = machine("car");
  CHECK(compare::find_equilibrium(model, *solver_by(who, model)).iterations <= 6);
}

TEST_CASE("An equilibrium is found with a closing for each step, not for each derivative", "[quick]") {
  const std::string who = GENERATE(as<std::string>{}, "cartesian", "relative");
  const Model model = machine("car");
  Counting solver(solver_by(who, model));
  const compare::Equilibrium found = compare::find_equilibrium(model, solver);
  INFO(who << ": " << solver.closings << " closings in " << found.iterations << " iterations");
  CHECK(solver.closings <= 8 * found.iterations);
}
