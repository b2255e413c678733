#include "tests/benchmarks/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <functional>
#include <map>
#include <ostream>
#include <vector>

#include "cartesian/solver.h"
#include "common/joints/revolute.h"
#include "common/joints/spherical.h"
#include "compare/report/text_table.h"
#include "compare/verdict/verify.h"
#include "relative/solver.h"
#include "tests/benchmarks/evaluators.h"

namespace concord::benchmarks {

namespace {

/// What the agreement of long chains leaves of 16 digits: their wrenches are sums over all bodies outboard.
constexpr double kNeededDigits = 11.0;
constexpr int kTurns = 21;
constexpr int kTurnsOfRuns = 3;
constexpr double kSlice = 0.01;  // s of evaluations in a turn
#ifdef CONCORD_HAS_SIMBODY
constexpr std::size_t kPrograms = 3;
#else
constexpr std::size_t kPrograms = 2;
#endif

double processor_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Processor seconds of `work`.
double time_of(const std::function<void()>& work) {
  const double began = processor_s();
  work();
  return processor_s() - began;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Of each program (cartesian, relative, Simbody) one value for each turn; none where it takes no part.
using Turns = std::array<std::vector<double>, kPrograms>;

/// What programs say, one after the other in each turn, so that whatever else the machine does slows all alike.
Turns take_turns(const std::vector<std::function<double()>>& programs, int turns) {
  Turns taken;
  for (int turn = 0; turn < turns; ++turn) {
    for (std::size_t k = 0; k < programs.size(); ++k) taken[k].push_back(programs[k]());
  }
  return taken;
}

/// Exponent p of time ~ N^p by least squares.
double exponent(const std::map<int, double>& times) {
  Eigen::MatrixX2d of_logarithms(times.size(), 2);
  VecX logarithms(times.size());
  Eigen::Index row = 0;
  for (const auto& [n, time] : times) {
    of_logarithms.row(row) << 1.0, std::log(n);
    logarithms(row++) = std::log(time);
  }
  return of_logarithms.colPivHouseholderQr().solve(logarithms)(1);
}

class Table {
 public:
  Table() {
    std::vector<std::string> head{"machine", "N", "in", "cartesian", "relative"};
    if (kPrograms > 2) head.emplace_back("Simbody");
    head.emplace_back("r / c");
    if (kPrograms > 2) head.insert(head.end(), {"c / S", "r / S"});
    head.emplace_back("digits");
    lines_.push_back(head);
  }

  /// A line of medians times `scale` and of medians of ratios; digits that agree.
  void add(const std::string& machine, int n, const std::string& unit, const Turns& turns, double scale,
           const std::string& digits = "") {
    std::vector<std::string> line{machine, std::to_string(n), unit};
    for (const std::vector<double>& of : turns) line.push_back(of.empty() ? "-" : number(median(of) * scale));
    line.push_back(ratio(turns[1], turns[0]));
    for (std::size_t k = 0; kPrograms > 2 && k < 2; ++k) line.push_back(ratio(turns[k], turns[kPrograms - 1]));
    line.push_back(digits);
    lines_.push_back(line);
  }

  /// A line of exponents over several N.
  void add_exponents(const std::string& machine, const std::array<std::map<int, double>, kPrograms>& times) {
    std::vector<std::string> line{machine, fmt::format("{}-{}", times[0].begin()->first, times[0].rbegin()->first),
                                  "exponent"};
    for (const auto& of : times) line.push_back(of.size() < 2 ? "-" : fmt::format("{:.2f}", exponent(of)));
    line.resize(lines_.front().size());
    lines_.push_back(line);
  }

  [[nodiscard]] std::string text() const {
    std::vector<bool> right(lines_.front().size(), true);
    right[0] = right[2] = false;
    return compare::format_table(lines_, right);
  }

 private:
  static std::string number(double value) {
    return value < 100.0 ? fmt::format("{:.3g}", value) : fmt::format("{:.0f}", value);
  }
  static std::string ratio(const std::vector<double>& one, const std::vector<double>& other) {
    if (one.empty() || other.empty()) return "-";
    std::vector<double> ratios;
    for (std::size_t turn = 0; turn < one.size(); ++turn) ratios.push_back(one[turn] / other[turn]);
    const double value = median(ratios);
    return value < 0.1 ? fmt::format("{:.2g}", value) : fmt::format("{:.2f}", value);
  }

  std::vector<std::vector<std::string>> lines_;
};

/// Fills the table, work by work.
class Bench {
 public:
  explicit Bench(const std::filesystem::path& data) : data_(data) {
    for (const int n : {16, 64, 256, 1024}) {
      add(fmt::format("chain, revolute, N = {}", n),
          [this, n] { evaluate("chain, revolute", n, make_chain(n, joints::revolute)); });
    }
    add_exponents("chain, revolute");
    add("chain, spherical", [this] { evaluate("chain, spherical", 256, make_chain(256, joints::spherical)); });
    add("tree", [this] { evaluate("tree", 255, make_tree(255)); });
    for (const int n : {20, 40, 80}) {
      add(fmt::format("ladder, N = {}", n), [this, n] { evaluate("ladder", n, make_ladder(n)); });
    }
    add_exponents("ladder");
    add("paper's", [this] { evaluate_and_run("paper's", "slider_crank_flexible"); });
    add("car", [this] { evaluate_and_run("car", "car"); });
    add("ladder, run", [this] { run("ladder", 40, make_ladder(40).model, 0.05); });
  }

  bool print(std::ostream& out, std::ostream& progress) {
    std::size_t k = 0;
    for (const auto& [what, work] : works_) {
      progress << fmt::format("measuring {} of {}: {}\n", ++k, works_.size(), what) << std::flush;
      work();
    }
    out << table_.text();
    if (kPrograms < 3)
      out << "without Simbody: libsimbody-dev is not installed, or the build was not told CONCORD_SIMBODY\n";
    for (const std::string& line : disagreements_) out << line;
    return disagreements_.empty();
  }

 private:
  void add(const std::string& what, const std::function<void()>& work) { works_.emplace_back(what, work); }
  void add_exponents(const std::string& machine) {
    add(machine + ", exponents", [this, machine] { table_.add_exponents(machine, medians_[machine]); });
  }

  /// One evaluation, in nanoseconds for each body.
  void evaluate(const std::string& what, int n, const Machine& machine, bool for_simbody = true) {
    std::vector<std::unique_ptr<Evaluator>> evaluators;
    evaluators.push_back(make_cartesian(machine));
    evaluators.push_back(make_relative(machine));
#ifdef CONCORD_HAS_SIMBODY
    if (for_simbody) evaluators.push_back(make_simbody(machine));
#else
    static_cast<void>(for_simbody);
#endif
    double digits = 16.0;
    for (const auto& evaluator : evaluators) {
      evaluator->evaluate();
      digits = std::min(digits, matching_digits(machine, *evaluator, *evaluators[0]));
    }
    if (!(digits >= kNeededDigits)) {
      disagreements_.push_back(
          fmt::format("{}, N = {}: reactions agree to {:.1f} digits, needed are {}\n", what, n, digits, kNeededDigits));
    }
    const Turns turns = take_turns(slices_of(evaluators), kTurns);
    table_.add(what, n, "ns per body", turns, 1e9 / machine.bodies(), fmt::format("{:.1f}", digits));
    for (std::size_t k = 0; k < evaluators.size(); ++k) medians_[what][k][n] = median(turns[k]);
  }

  /// For each evaluator: as many evaluations as fill a slice, and what one of them takes [s].
  static std::vector<std::function<double()>> slices_of(const std::vector<std::unique_ptr<Evaluator>>& evaluators) {
    std::vector<std::function<double()>> slices;
    for (const auto& evaluator : evaluators) {
      const auto repeat = [&evaluator](int times) {
        return time_of([&] {
                 for (int k = 0; k < times; ++k) evaluator->evaluate();
               }) /
               times;
      };
      const int times = std::max(1, static_cast<int>(kSlice / repeat(3)));
      slices.emplace_back([repeat, times] { return repeat(times); });
    }
    return slices;
  }

  void evaluate_and_run(const std::string& what, const std::string& name) {
    const Machine machine = read_machine(data_ / "models" / (name + ".toml"));
    evaluate(what, machine.bodies(), machine, false);
    run(what, machine.bodies(), machine.model, machine.model.run.until);
  }

  /// Whole runs at the default tolerance: processor seconds, and what follows from them.
  void run(const std::string& what, int n, const Model& model, double until) {
    RunOptions options = compare::run_options(model, {});
    options.until = until;
    std::vector<std::unique_ptr<Solver>> solvers;
    solvers.push_back(cartesian::make_solver(model));
    solvers.push_back(relative::make_solver(model));
    Turns evaluations;
    std::vector<std::function<double()>> runs;
    for (std::size_t k = 0; k < solvers.size(); ++k) {
      runs.emplace_back([&, k] {
        return time_of([&] {
          const SolverStatistics done = solvers[k]->integrate(options, [](double /*t*/) {}).statistics;
          evaluations[k].push_back(static_cast<double>(done.evaluations));
        });
      });
    }
    const Turns turns = take_turns(runs, kTurnsOfRuns);
    Turns times_real;
    for (std::size_t k = 0; k < solvers.size(); ++k) {
      for (const double s : turns[k]) times_real[k].push_back(until / s);
    }
    const std::string title = fmt::format("{}, {} s", what, until);
    table_.add(title, n, "processor s", turns, 1.0);
    table_.add(title, n, "evaluations", evaluations, 1.0);
    table_.add(title, n, "x real time", times_real, 1.0);
  }

  std::filesystem::path data_;
  std::vector<std::pair<std::string, std::function<void()>>> works_;
  Table table_;
  std::map<std::string, std::array<std::map<int, double>, kPrograms>> medians_;  // [s] by machine, program and N
  std::vector<std::string> disagreements_;
};

}  // namespace

bool print_table(const std::filesystem::path& data, std::ostream& out, std::ostream& progress) {
  return Bench(data).print(out, progress);
}

}  // namespace concord::benchmarks
