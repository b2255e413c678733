#include "cartesian/pace.h"

#include <fmt/format.h>

#include <utility>

#include "common/error.h"

namespace concord::cartesian {

Pace::Pace(double until, std::string advice, double cost) : until_(until), advice_(std::move(advice)) {
  for (Window& window : windows_) window.most = static_cast<long>(double(window.most) / cost);
}

void Pace::require(double t, long evaluations) {
  for (Window& window : windows_) {
    const long taken = evaluations - window.evaluations_then;
    if (taken > window.most) {
      throw TooManyEvaluations(fmt::format(
          "cartesian: at t = {:.6g} s {} evaluations brought the run {:.1e} s further: the motion locks there, "
          "or is too stiff for this integrator{}",
          t, window.most, t - window.since, advice_));
    }
    if (t - window.since > window.part * until_) {
      window.since = t;
      window.evaluations_then = evaluations;
    }
  }
}

}  // namespace concord::cartesian
