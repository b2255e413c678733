/// Where the time of the car goes: the parts of one evaluation by each solver, what the sparse factors alone take, and
/// a run of its 10 s. Before anything is timed, both solvers must agree on the reactions.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cartesian/dynamics/dynamics.h"
#include "cartesian/dynamics/equations.h"
#include "cartesian/dynamics/reactions.h"
#include "cartesian/solver.h"
#include "common/reading/model_file.h"
#include "compare/equilibrium/started_machine.h"
#include "relative/dynamics/equations.h"
#include "relative/solver.h"
#include "relative/start/states.h"

namespace concord::benchmarks {
namespace {

constexpr double kNeededDigits = 11.0;
constexpr double kMicro = 1e6;

/// The car on its springs, by both solvers' equations, and the factors of the sparse one by themselves.
struct Car {
  explicit Car(const Model& settled)
      : model(settled),
        relative(model),
        cartesian(model),
        dynamics(cartesian),
        q(VecX::Zero(cartesian.layout().n_q())),
        Y(VecX::Zero(cartesian.layout().n_Y())) {
    const State state = relative::make_solver(model)->assemble();
    relative::StateMisfit misfit;
    coordinates = relative::States(relative).read(state, misfit);
    evaluate_relative();
    cartesian.layout().unpack(state, q, Y);
    cartesian.update(0.0, q, Y);
    const cartesian::SparseLu& matrix = dynamics.fill_matrix();
    factors = std::make_unique<cartesian::SparseLu>(matrix.column_starts(), matrix.row_indices(),
                                                    cartesian::SparseLu::Pattern::symmetric);
    std::copy_n(matrix.values(), matrix.row_indices().size(), factors->values());
    factors->factor();
    right_side = VecX::Ones(matrix.size());
  }

  void evaluate_relative() {
    const relative::Evaluated& evaluated = relative.compute_accelerations(coordinates.t, coordinates.q, coordinates.u);
    reactions = &relative.compute_reactions(evaluated);
  }
  void evaluate_cartesian() { solved = &dynamics.solve_at(0.0, q, Y, cartesian::Pivots::kept); }
  void factor_and_solve() {
    factors->refactor();
    solution = right_side;
    factors->solve(solution);
  }

  /// Matching digits of the force in all joints, relative to the largest.
  [[nodiscard]] double matching_digits() const {
    double largest = 0.0;
    double apart = 0.0;
    for (const cartesian::JointIndex k : cartesian::indices_of(model.joints)) {
      const cartesian::JointEquations& joint = cartesian.moving_constraints().joint(k);
      const VecX lambda = solved->lambda().segment(joint.first_row.value, joint.n_rows);
      const Vec3 one = cartesian::compute_wrenches(model.joints[k.value], joint, lambda, nullptr)
                           .reaction_on(Side::child)
                           .in_global.force;
      const Vec3 other = reactions->joints[k.value].reaction_on(Side::child).in_global.force;
      largest = std::max(largest, one.norm());
      apart = std::max(apart, (one - other).norm());
    }
    return -std::log10(std::max(apart / largest, 1e-16));
  }

  const Model& model;
  relative::Equations relative;
  relative::Coordinates coordinates;
  const relative::JointReactions* reactions = nullptr;
  cartesian::Equations cartesian;
  cartesian::Dynamics dynamics;
  const cartesian::Solution* solved = nullptr;  // the last
  VecX q;
  VecX Y;
  std::unique_ptr<cartesian::SparseLu> factors;
  VecX right_side;
  VecX solution;
};

/// Keeps the median of the repetitions of every part, in microseconds.
class PartTimes : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context& /*context*/) override { return true; }

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.error_occurred || run.run_type != Run::RT_Iteration) continue;
      times_[run.run_name.function_name].push_back(run.cpu_accumulated_time / static_cast<double>(run.iterations) *
                                                   kMicro);
    }
  }

  /// False if a filter left some parts out.
  [[nodiscard]] bool has_all() const { return times_.size() == kParts; }

  [[nodiscard]] double of(const std::string& part) const {
    std::vector<double> times = times_.at(part);
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
  }

 private:
  static constexpr std::size_t kParts = 7;
  std::map<std::string, std::vector<double>> times_;
};

void print_row(const std::string& what, double us, const std::string& share) {
  fmt::print("| {:<58} | {:>8.2f} | {:<42} |\n", what, us, share);
}

void print_parts(const PartTimes& times) {
  const double relative = times.of("relative: accelerations") + times.of("relative: reactions");
  const double cartesian = times.of("cartesian: evaluation");
  const double klu = times.of("KLU: refactor and solve");
  fmt::print("\n| {:<58} | {:>8} | {:<42} |\n|{:-<60}|{:->9}:|{:-<44}|\n", "one evaluation", "us", "", "", "", "");
  const auto part = [&](const std::string& what, double us) {
    print_row(what, us, fmt::format("{:.0f} % of relative", 100.0 * us / relative));
  };
  const double moved = times.of("relative: move");
  const double pushed = times.of("relative: move and forces");
  part("relative: positions and velocities, cut joints measured", moved);
  part("relative: force elements, tires", pushed - moved);
  part("relative: articulated-body passes, loops closed", times.of("relative: accelerations") - pushed);
  part("relative: reactions of all joints", times.of("relative: reactions"));
  print_row("cartesian: positions, velocities, rows, forces", times.of("cartesian: update"),
            fmt::format("{:.0f} % of cartesian", 100.0 * times.of("cartesian: update") / cartesian));
  print_row("KLU alone: refactor and solve of the same matrix", klu,
            fmt::format("{:.0f} % of cartesian", 100.0 * klu / cartesian));
  print_row("relative, whole", relative, fmt::format("cartesian takes {:.1f} times as long", cartesian / relative));
  print_row("cartesian, matrix assembled, factored, solved, refined", cartesian,
            fmt::format("{:.2f} times KLU alone", cartesian / klu));
}

/// Simulated over wall time at the default tolerance: the median of several runs, one solver after the other.
void print_runs(const Model& model, int repetitions) {
  RunOptions options;
  options.until = model.run.until;
  fmt::print("\n| {:<9} | {:>6} | {:>11} | {:>7} | {:>15} |\n", "run", "steps", "evaluations", "wall s",
             "times real time");
  fmt::print("|{:-<11}|{:->7}:|{:->12}:|{:->8}:|{:->16}:|\n", "", "", "", "", "");
  for (const bool by_relative : {true, false}) {
    const auto solver = by_relative ? relative::make_solver(model) : cartesian::make_solver(model);
    std::vector<double> walls;
    SolverStatistics statistics;
    for (int k = 0; k < repetitions; ++k) {
      statistics = solver->integrate(options, [](double) {}).statistics;
      walls.push_back(statistics.wall_s);
    }
    std::sort(walls.begin(), walls.end());
    const double wall = walls[walls.size() / 2];
    fmt::print("| {:<9} | {:>6} | {:>11} | {:>7.3f} | {:>15.1f} |\n", solver->name(), statistics.steps,
               statistics.evaluations, wall, options.until / wall);
  }
}

void add_benchmarks(Car& car) {
  const auto add = [](const char* name, auto evaluate) {
    benchmark::RegisterBenchmark(name, [evaluate](benchmark::State& state) {
      for (auto _ : state) evaluate();
    });
  };
  const relative::Coordinates& at = car.coordinates;
  add("relative: move", [&] { car.relative.move(at.t, at.q, at.u); });
  add("relative: move and forces", [&] { car.relative.update_forces(at.t, at.q, at.u); });
  add("relative: accelerations", [&] { car.relative.compute_accelerations(at.t, at.q, at.u); });
  benchmark::RegisterBenchmark("relative: reactions", [&](benchmark::State& state) {
    const relative::Evaluated& evaluated = car.relative.compute_accelerations(at.t, at.q, at.u);
    for (auto _ : state) car.relative.compute_reactions(evaluated);
  });
  add("cartesian: update", [&] { car.cartesian.update(0.0, car.q, car.Y); });
  add("cartesian: evaluation", [&] { car.evaluate_cartesian(); });
  add("KLU: refactor and solve", [&] { car.factor_and_solve(); });
}

}  // namespace
}  // namespace concord::benchmarks

int main(int argc, char** argv) {
  using namespace concord;
  using namespace concord::benchmarks;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  std::string note;
  const Model model = compare::as_it_starts(read_model(std::filesystem::path(CONCORD_DATA) / "models/car.toml"),
                                            {cartesian::make_solver, relative::make_solver}, note);
  Car car(model);
  const double digits = car.matching_digits();
  fmt::print("the car at its equilibrium: reactions agree to {:.1f} digits between the solvers\n", digits);
  if (!(digits >= kNeededDigits)) {
    fmt::print(stderr, "needed are {}: nothing is timed\n", kNeededDigits);
    return 1;
  }
  add_benchmarks(car);
  PartTimes times;
  benchmark::RunSpecifiedBenchmarks(&times);
  if (times.has_all()) print_parts(times);
  print_runs(model, 5);
  return 0;
}
