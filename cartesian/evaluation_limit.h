#pragma once

#include <array>
#include <optional>
#include <string>

namespace concord::cartesian {

/// Refuses a run that would take hours: an explicit method on a stiff machine, or a motion into a pose that locks. A
/// short hard phase, such as an impact, may take its part; a run that is hard throughout may not.
class EvaluationLimit {
 public:
  /// `until` [s] is the length of the run. An integrator whose evaluations cost `cost` times as much as those of an
  /// explicit one may make so many fewer. `most`: of the whole run, of either kind alike; with `foresees_end` a tenth
  /// of them, after which twice as many are to be expected, ends the run already.
  EvaluationLimit(double until, std::string integrator, double cost = 1.0, std::optional<long> most = std::nullopt,
                  bool foresees_end = false);

  /// Throws TooManyEvaluations if a thousandth, a hundredth or a tenth of the run took more evaluations than it may,
  /// EvaluationsSpent if the whole run did.
  /// `t` [s] has been reached, with so many evaluations since the start.
  void require(double t, long evaluations);

 private:
  /// A part of the run that is being counted.
  struct Window {
    double part;  // of the run
    long most;
    double since = 0.0;  // s
    long evaluations_then = 0;
  };

  double until_;
  std::string integrator_;
  std::optional<long> most_;
  bool foresees_end_;
  std::array<Window, 3> windows_{{{1e-3, 300'000}, {1e-2, 400'000}, {1e-1, 2'400'000}}};
};

}  // namespace concord::cartesian
