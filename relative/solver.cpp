#include "relative/solver.h"

#include <fmt/format.h>

#include "relative/integration.h"
#include "relative/rank.h"
#include "relative/states.h"

namespace concord::relative {

namespace {

constexpr double kLargestMisfit = 1e-12;

class RelativeSolver final : public Solver {
 public:
  explicit RelativeSolver(const Model& model)
      : model_(model), equations_(model_), assembly_(equations_), states_(equations_) {}

  [[nodiscard]] std::string_view name() const override { return "relative"; }

  [[nodiscard]] std::vector<std::string> integrators() const override { return integrator_names(model_); }

  State assemble() override {
    const Coordinates start = assembly_.start();
    equations_.move(start.t, start.q, start.u);
    return states_.write(start.t, {});
  }

  std::optional<State> close(const State& guess) override {
    states_.require_shape(guess);
    try {
      StateMisfit misfit;
      Coordinates coordinates = states_.read(guess, misfit);
      if (!assembly_.close(coordinates)) return std::nullopt;
      equations_.move(coordinates.t, coordinates.q, coordinates.u);
      return states_.write(guess.t, guess);
    } catch (const SolverError&) {
      return std::nullopt;  // a joint without all its motions, or a deformation out of range, at the guess
    }
  }

  Evaluation evaluate(const State& state) override {
    const Coordinates coordinates = read_closed(state);
    assembly_.choose_rows(coordinates);
    equations_.compute_accelerations(coordinates.t, coordinates.q, coordinates.u);
    equations_.compute_reactions();
    require_modal_balance(equations_, state.t);
    return states_.write_evaluation();
  }

  RankReport rank(const State& state) override {
    return analyze_rank(equations_, assembly_.scales(), read_closed(state));
  }

  MatX tangent(const State& state) override {
    return permitted_velocities(equations_, assembly_.scales(), read_closed(state));
  }

  Trajectory integrate(const RunOptions& options, const Progress& progress) override {
    return relative::integrate(equations_, assembly_, states_, options, progress);
  }

  [[nodiscard]] std::vector<std::string> cut_joints() const override {
    std::vector<std::string> names;
    for (const int k : equations_.topology().cuts) names.push_back(model_.joints[k].name);
    return names;
  }

 private:
  Coordinates read_closed(const State& state) {
    StateMisfit misfit;
    Coordinates coordinates = states_.read(state, misfit);
    if (misfit.largest <= kLargestMisfit) return coordinates;
    throw SolverError(
        fmt::format("relative: the state at t = {:.6g} s is not closed: residual {:.1e} at {}, allowed "
                    "{:.0e}: close it first",
                    state.t, misfit.largest, misfit.where, kLargestMisfit));
  }

  Model model_;
  Equations equations_;
  Assembly assembly_;
  States states_;
};

}  // namespace

std::unique_ptr<Solver> make_solver(const Model& model) { return std::make_unique<RelativeSolver>(model); }

}  // namespace concord::relative
