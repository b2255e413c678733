#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>

namespace concord {

/// Refuses a run that would take hours: an explicit method on a stiff machine, or a motion into a pose that locks. A
/// short hard phase, such as an impact, may take its part; a run that is hard throughout may not.
class EvaluationLimit {
 public:
  struct Of {
    std::string solver;      // in whose name a message speaks
    std::string integrator;  // its name, for the message
    double until;            // the length of the run [s]
    /// What the whole run may take (RunOptions::most_evaluations), and whether a tenth of that ends it already where
    /// twice as many are to be expected (RunOptions::foresees_end).
    std::optional<long> most = {};
    bool foresees_end = false;
    /// How many times as long as one of an explicit integrator an evaluation takes: so many fewer are allowed, but for
    /// those of the whole run.
    double cost = 1.0;
  };

  explicit EvaluationLimit(Of run);

  /// `t` [s] has been reached, with so many evaluations since the start. Throws TooManyEvaluations if a thousandth, a
  /// hundredth or a tenth of the run took more evaluations than it may, with what `place` says of why at the end of the
  /// message; EvaluationsSpent if the whole run did.
  void require(double t, long evaluations, const std::function<std::string()>& place = {});

 private:
  /// A part of the run that is being counted.
  struct Window {
    double part;  // of the run
    long most;
    double since = 0.0;  // s
    long evaluations_then = 0;
  };

  Of run_;
  std::array<Window, 3> windows_{{{1e-3, 300'000}, {1e-2, 400'000}, {1e-1, 2'400'000}}};
};

}  // namespace concord
