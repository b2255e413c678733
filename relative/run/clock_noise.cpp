#include "relative/run/clock_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/error.h"
#include "common/laws/break_times.h"

namespace concord::relative {

namespace {

constexpr long kEvery = 32;           // steps: a thirtieth of the cost
constexpr double kPartOfStep = 1e-2;  // over which rates are differenced
constexpr double kUnits = 2.0;        // of round-off of the time
constexpr double kForgets = 0.9;      // from one measurement to the next: laws rise and fall

}  // namespace

ClockNoise::ClockNoise(const Model& model, Eigen::Index size)
    : is_needed_(has_laws_of_time(model)),
      now_(VecX::Zero(size)),
      later_(VecX::Zero(size)),
      change_(VecX::Zero(size)),
      of_step_(VecX::Zero(size)) {}

void ClockNoise::pass(double t, const Eigen::Ref<const VecX>& y, const Rates& rates) {  // (R74)
  if (!is_needed_) return;
  h_ = std::max(t - before_, kForgets * h_);  // steps that end at a sample are shorter
  before_ = t;
  if (++steps_ % kEvery != 0 || !(h_ > 0.0)) return;
  const double ahead = t + kPartOfStep * h_;
  try {
    rates(t, y, now_);
    rates(ahead, y, later_);
  } catch (const SolverError&) {
    return;
  }
  const double noise = kUnits * std::numeric_limits<double>::epsilon() * t * h_ / (ahead - t);
  change_ = (noise * (later_ - now_)).cwiseAbs();
  if (change_.allFinite()) of_step_ = change_.cwiseMax(kForgets * of_step_);
}

}  // namespace concord::relative
