#include "cartesian/evaluation_limit.h"

#include <fmt/format.h>

#include <utility>

#include "common/error.h"

namespace concord::cartesian {

EvaluationLimit::EvaluationLimit(double until, std::string integrator, double cost, std::optional<long> most)
    : until_(until), integrator_(std::move(integrator)), most_(most) {
  for (Window& window : windows_) window.most = static_cast<long>(double(window.most) / cost);
}

void EvaluationLimit::require(double t, long evaluations) {
  if (most_ && evaluations > *most_) {
    throw EvaluationsSpent(fmt::format("cartesian: {} evaluations by {} were enough for {:.3g} s of {:.3g} s only",
                                       *most_, integrator_, t, until_));
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
