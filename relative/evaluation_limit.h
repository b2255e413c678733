#pragma once

#include <optional>
#include <string>

#include "relative/coordinates.h"
#include "relative/equations.h"

namespace concord::relative {

/// Counts what a run costs and refuses one that gets nowhere. Three counts begin anew after a thousandth, a hundredth
/// and a tenth of the run; an event that is hard but short stays within them.
class EvaluationLimit {
 public:
  /// `until` [s]: the length of the run; `integrator`: its name, for the message; `whole`: what the whole run may take;
  /// `foresees_end`: RunOptions::foresees_end.
  EvaluationLimit(double until, std::string integrator, std::optional<long> whole = std::nullopt,
                  bool foresees_end = false);

  /// Throws TooManyEvaluations where `evaluations` since the start of the run are too many for what it gained up to
  /// t [s]. The message names the loop with the largest multiplier, or the joint whose motion is the fastest.
  void pass(double t, long evaluations, Equations& equations, const Coordinates& coordinates);

 private:
  [[nodiscard]] bool is_spent(double t, long evaluations) const;

  struct Count {
    double part;
    long most;
    double from_t = 0.0;
    long from_evaluations = 0;
  };

  double until_;
  std::string integrator_;
  std::optional<long> whole_;
  bool foresees_end_;
  Count counts_[3] = {{1e-3, 300'000}, {1e-2, 400'000}, {0.1, 2'400'000}};
};

/// The joint whose own speed changes its own acceleration, or whose own place does, at the largest rate
/// [1/s] at these coordinates; empty if all are zero. For messages.
struct FastestMotion {
  std::string of;
  double rate = 0.0;
};
FastestMotion fastest_motion(Equations& equations, const Coordinates& coordinates);

}  // namespace concord::relative
