/// Accelerations and all joint reactions of a revolute chain with tilted frames, N bodies, in ns per body: both
/// solvers, and Simbody where it is installed. Before anything is timed, all must agree on the reactions.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "cartesian/dynamics/dynamics.h"
#include "cartesian/dynamics/equations.h"
#include "cartesian/dynamics/reactions.h"
#include "relative/dynamics/equations.h"
#include "relative/start/states.h"
#include "tests/benchmarks/chain.h"
#ifdef CONCORD_HAS_SIMBODY
#include "tests/benchmarks/simbody_chain.h"
#endif

namespace concord::benchmarks {
namespace {

constexpr int kSmallest = 4;
constexpr int kLargest = 1024;
/// What the agreement of long chains leaves of 16 digits: their wrenches are sums over all bodies outboard.
constexpr double kNeededDigits = 11.0;

class RelativeChain {
 public:
  explicit RelativeChain(const Chain& chain) : equations_(chain.model) {
    relative::StateMisfit misfit;
    coordinates_ = relative::States(equations_).read(chain.state, misfit);
  }

  void evaluate() {
    const auto& evaluated = equations_.compute_accelerations(coordinates_.t, coordinates_.q, coordinates_.u);
    reactions_ = &equations_.compute_reactions(evaluated);
  }
  [[nodiscard]] Wrench reaction(int joint) const {
    return reactions_->joints[joint].reaction_on(Side::child).in_global;
  }

 private:
  relative::Equations equations_;
  relative::Coordinates coordinates_;
  const relative::JointReactions* reactions_ = nullptr;
};

class CartesianChain {
 public:
  explicit CartesianChain(const Chain& chain)
      : model_(chain.model),
        equations_(chain.model),
        dynamics_(equations_),
        q_(VecX::Zero(equations_.layout().n_q())),
        Y_(VecX::Zero(equations_.layout().n_Y())) {
    equations_.layout().unpack(chain.state, q_, Y_);
    dynamics_.solve_at(0.0, q_, Y_, cartesian::Pivots::fresh);
    wrenches_.resize(model_.joints.size());
  }

  void evaluate() {
    const cartesian::Solution& solution = dynamics_.solve_at(0.0, q_, Y_, cartesian::Pivots::kept);
    for (const cartesian::JointIndex k : cartesian::indices_of(model_.joints)) {
      const cartesian::JointEquations& joint = equations_.moving_constraints().joint(k);
      const auto lambda = solution.lambda().segment(joint.first_row.value, joint.n_rows);
      cartesian::write_wrenches(model_.joints[k.value], joint, lambda, nullptr, wrenches_[k.value]);
    }
  }
  [[nodiscard]] Wrench reaction(int joint) const { return wrenches_[joint].reaction_on(Side::child).in_global; }

 private:
  const Model& model_;
  cartesian::Equations equations_;
  cartesian::Dynamics dynamics_;
  VecX q_;
  VecX Y_;
  std::vector<JointWrenches> wrenches_;
};

/// Matching digits of all reactions, relative to the largest force and torque of the chain.
template <class One, class Other>
double matching_digits(const One& one, const Other& other, int n) {
  Wrench scale{Vec3::Zero(), Vec3::Zero()};
  Vec3 force_error = Vec3::Zero();
  Vec3 torque_error = Vec3::Zero();
  for (int k = 0; k < n; ++k) {
    scale.force = scale.force.cwiseMax(Vec3::Constant(one.reaction(k).force.norm()));
    scale.torque = scale.torque.cwiseMax(Vec3::Constant(one.reaction(k).torque.norm()));
    force_error = force_error.cwiseMax((one.reaction(k).force - other.reaction(k).force).cwiseAbs());
    torque_error = torque_error.cwiseMax((one.reaction(k).torque - other.reaction(k).torque).cwiseAbs());
  }
  const double error = std::max(force_error.maxCoeff() / scale.force(0), torque_error.maxCoeff() / scale.torque(0));
  return error > 0.0 ? std::min(16.0, -std::log10(error)) : (error == 0.0 ? 16.0 : 0.0);
}

/// Prints how well all agree on chains of several lengths; false if one does not.
bool check_agreement() {
  bool good = true;
  for (int n = kSmallest; n <= kLargest; n *= 16) {
    const Chain chain = make_chain(n);
    RelativeChain relative(chain);
    CartesianChain cartesian(chain);
    relative.evaluate();
    cartesian.evaluate();
    const double solvers = matching_digits(relative, cartesian, n);
    good = good && solvers >= kNeededDigits;
    fmt::print("N = {:4}: reactions agree to {:.1f} digits between the solvers", n, solvers);
#ifdef CONCORD_HAS_SIMBODY
    SimbodyChain simbody(chain);
    simbody.evaluate();
    const double outside = matching_digits(relative, simbody, n);
    good = good && outside >= kNeededDigits;
    fmt::print(", {:.1f} between relative and Simbody", outside);
#endif
    fmt::print("\n");
  }
  return good;
}

template <class Evaluator>
void evaluate_chain(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  const Chain chain = make_chain(n);
  Evaluator evaluator(chain);
  for (auto _ : state) {
    evaluator.evaluate();
    benchmark::DoNotOptimize(evaluator.reaction(n - 1));
  }
}

/// Collects the best time of every solver and length, and ends with a table and the slopes.
class TableReporter : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context& /*context*/) override { return true; }

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.error_occurred || run.run_type != Run::RT_Iteration) continue;
      const int n = std::stoi(run.run_name.args);
      const double ns = run.cpu_accumulated_time / static_cast<double>(run.iterations) * 1e9;
      auto& times = times_[run.run_name.function_name];
      const auto known = times.find(n);
      times[n] = known == times.end() ? ns : std::min(known->second, ns);
    }
  }

  void Finalize() override {
    fmt::print("\naccelerations and all reactions, ns per body (best of the repetitions)\n{:>6}", "N");
    for (const auto& [name, times] : times_) fmt::print("{:>12}", name);
    fmt::print("\n");
    for (int n = kSmallest; n <= kLargest; n *= 2) {
      fmt::print("{:>6}", n);
      for (const auto& [name, times] : times_) {
        const auto found = times.find(n);
        fmt::print("{:>12}", found == times.end() ? "-" : fmt::format("{:.0f}", found->second / n));
      }
      fmt::print("\n");
    }
    fmt::print("{:>6}", "slope");
    for (const auto& [name, times] : times_) fmt::print("{:>12.3f}", slope(times));
    fmt::print("\nslope: fitted exponent of time over N on logarithmic scales; 1 is proportional to N\n");
    within_limits_ = keeps("relative", kRelativeSlope) && keeps("cartesian", kCartesianSlope) && is_not_slower();
  }

  /// Of what was measured: slopes at most these, and relative at no length slower than Simbody.
  [[nodiscard]] bool within_limits() const { return within_limits_; }

 private:
  static constexpr double kRelativeSlope = 1.1;
  static constexpr double kCartesianSlope = 1.2;

  /// A slope through fewer than four lengths says nothing.
  [[nodiscard]] bool keeps(const std::string& name, double largest) const {
    const auto found = times_.find(name);
    if (found == times_.end() || found->second.size() < 4 || slope(found->second) <= largest) return true;
    fmt::print("{}: slope {:.3f}, allowed {}\n", name, slope(found->second), largest);
    return false;
  }

  [[nodiscard]] bool is_not_slower() const {
    bool good = true;
    const auto own = times_.find("relative");
    const auto outside = times_.find("simbody");
    if (own == times_.end() || outside == times_.end()) return true;
    for (const auto& [n, ns] : outside->second) {
      const auto found = own->second.find(n);
      if (found == own->second.end() || found->second <= ns) continue;
      fmt::print("relative: slower than Simbody at N = {}\n", n);
      good = false;
    }
    return good;
  }

  /// Least squares of log(time) over log(N).
  static double slope(const std::map<int, double>& times) {
    double count = 0.0;
    double x = 0.0;
    double y = 0.0;
    double xx = 0.0;
    double xy = 0.0;
    for (const auto& [n, ns] : times) {
      count += 1.0;
      x += std::log(n);
      y += std::log(ns);
      xx += std::log(n) * std::log(n);
      xy += std::log(n) * std::log(ns);
    }
    return (count * xy - x * y) / (count * xx - x * x);
  }

  std::map<std::string, std::map<int, double>> times_;
  bool within_limits_ = true;
};

template <class Evaluator>
void add_benchmark(const char* name) {
  benchmark::RegisterBenchmark(name, evaluate_chain<Evaluator>)->RangeMultiplier(2)->Range(kSmallest, kLargest);
}

}  // namespace
}  // namespace concord::benchmarks

int main(int argc, char** argv) {
  using namespace concord::benchmarks;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  add_benchmark<RelativeChain>("relative");
  add_benchmark<CartesianChain>("cartesian");
#ifdef CONCORD_HAS_SIMBODY
  add_benchmark<SimbodyChain>("simbody");
#endif
  if (!check_agreement()) {
    fmt::print(stderr, "the chains do not agree to {} digits: nothing is timed\n", kNeededDigits);
    return 1;
  }
  TableReporter table;
  benchmark::RunSpecifiedBenchmarks(&table);
  return table.within_limits() ? 0 : 1;
}
