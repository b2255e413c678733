#include "common/evaluation_limit.h"

#include <fmt/format.h>

#include <utility>

#include "common/error.h"

namespace concord {

EvaluationLimit::EvaluationLimit(Of run) : run_(std::move(run)) {
  for (Window& window : windows_) window.most = static_cast<long>(double(window.most) / run_.cost);
}

void EvaluationLimit::require(double t, long evaluations, const std::function<std::string()>& place) {
  if (run_.most) {
    const double part_of_run = t / run_.until;
    const double part_given = double(evaluations) / double(*run_.most);
    const bool is_slow = part_given > 0.1 && part_given > 2.0 * part_of_run;
    if (part_given > 1.0 || (run_.foresees_end && is_slow)) {
      throw EvaluationsSpent(
          fmt::format("{}: {} evaluations by {}, which was given {}, were enough for {:.3g} s of {:.3g} s only",
                      run_.solver, evaluations, run_.integrator, *run_.most, t, run_.until));
    }
  }
  for (Window& window : windows_) {
    if (evaluations - window.evaluations_then > window.most) {
      throw TooManyEvaluations(fmt::format(
          "{}: at t = {:.6g} s {} evaluations advanced the run by {:.1e} s only: the run is long beside the "
          "motion, or the motion locks there, or is too stiff for {}{}",
          run_.solver, t, window.most, t - window.since, run_.integrator, place ? place() : ""));
    }
    if (t - window.since > window.part * run_.until) {
      window.since = t;
      window.evaluations_then = evaluations;
    }
  }
}

}  // namespace concord
