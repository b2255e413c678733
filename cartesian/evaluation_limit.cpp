#include "cartesian/evaluation_limit.h"

#include <fmt/format.h>

#include <utility>

#include "common/error.h"

namespace concord::cartesian {

EvaluationLimit::EvaluationLimit(double until, std::string integrator, double cost, std::optional<long> most,
                                 bool foresees_end)
    : until_(until), integrator_(std::move(integrator)), most_(most), foresees_end_(foresees_end) {
  for (Window& window : windows_) window.most = static_cast<long>(double(window.most) / cost);
}

void EvaluationLimit::require(double t, long evaluations) {
  if (most_) {
    const double part_of_run = t / until_;
    const double part_given = double(evaluations) / double(*most_);
    const bool is_slow = part_given > 0.1 && part_given > 2.0 * part_of_run;
    if (part_given > 1.0 || (foresees_end_ && is_slow)) {
      throw EvaluationsSpent(
          fmt::format("cartesian: {} evaluations by {}, which was given {}, were enough for {:.3g} s "
                      "of {:.3g} s only",
                      evaluations, integrator_, *most_, t, until_));
    }
  }
  for (Window& window : windows_) {
    const long taken = evaluations - window.evaluations_then;
    if (taken > window.most) {
      throw TooManyEvaluations(
          fmt::format("cartesian: at t = {:.6g} s {} evaluations advanced the run by {:.1e} s only: the run is long "
                      "beside the motion, or the motion locks there, or is too stiff for {}",
                      t, window.most, t - window.since, integrator_));
    }
    if (t - window.since > window.part * until_) {
      window.since = t;
      window.evaluations_then = evaluations;
    }
  }
}

}  // namespace concord::cartesian
