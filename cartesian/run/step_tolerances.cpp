#include "cartesian/run/step_tolerances.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cartesian/dynamics/state_scales.h"
#include "common/error.h"
#include "common/laws/break_times.h"

namespace concord::cartesian {

namespace {

constexpr double kTwoRoundOffs = 2.0 * std::numeric_limits<double>::epsilon();

}  // namespace

StepTolerances::StepTolerances(Dynamics& dynamics, const MotionState& start, Tolerance tolerance)
    : dynamics_(dynamics),
      layout_(dynamics.equations().layout()),
      tolerance_(tolerance),
      asked_(tolerance.rtol * motion_sizes(dynamics.equations(), start.q, start.Y, tolerance.until)),
      absolute_(asked_),
      has_laws_of_time_(has_laws_of_time(dynamics.equations().model())),
      noise_(VecX::Zero(layout_.n_Y())) {
  share_of_modes_ = share_for(start);
  round_off_ = measure_round_off(0.0, start);
  absolute_.head(round_off_.size()) = wanted_of_motion();
}

bool StepTolerances::follow(double t, double step, const MotionState& motion, double largest_work) {
  bool changed = follow_work(largest_work);
  changed = follow_modes(t, motion) || changed;
  return (has_laws_of_time_ && follow_time(t, step, motion)) || changed;
}

/// Errors of the work count against the largest that it has been: drivers may take it back to nothing.
bool StepTolerances::follow_work(double largest_work) {
  constexpr double kFinest = 1e-12;  // of it: below, laws that change fast leave the round-off of time in the power
  const double needed = std::max(tolerance_.rtol, kFinest) * largest_work;
  double& allowed = absolute_(absolute_.size() - 1);
  if (needed <= 2.0 * allowed) return false;
  allowed = needed;
  return true;
}

/// Vibrations may be small beside what bodies would do if they vibrated as fast as they move, and joints carry what
/// modes do all the same: errors of modes count against the largest vibration so far.
bool StepTolerances::follow_modes(double t, const MotionState& motion) {
  const double share = share_for(motion);
  if (share <= 2.0 * share_of_modes_) return false;
  share_of_modes_ = share;
  try {
    round_off_ = measure_round_off(t, motion);
  } catch (const SolverError&) {  // beside a state that is hardly one: as it was
  }
  absolute_.head(round_off_.size()) = wanted_of_motion();
  return true;
}

/// (C63)
double StepTolerances::share_for(const MotionState& motion) const {
  constexpr double kLeast = 1e-6;  // where next to nothing vibrates
  double largest = 0.0;
  const auto look_at = [&](const auto& modes, const auto& asked) {
    if (modes.size() > 0) largest = std::max(largest, modes.cwiseQuotient(asked).cwiseAbs().maxCoeff());
  };
  for (const BodyIndex i : layout_.moving_bodies()) {
    look_at(layout_.a(motion.q, i), layout_.a(asked_.head(layout_.n_q()), i));
    look_at(layout_.adot(motion.Y, i), layout_.adot(asked_.segment(layout_.n_q(), layout_.n_Y()), i));
  }
  return std::clamp(tolerance_.rtol * largest, kLeast, 1.0);
}

/// Laws of time know their time to its last digit only, so that what changes with time itself comes with noise: what
/// a step makes of it in the speeds is not asked for, or steps become shorter and shorter. True where it has doubled
/// or halved.
bool StepTolerances::follow_time(double t, double step, const MotionState& motion) {
  constexpr int kSteps = 6;  // from one look to the next
  longest_ = std::max(longest_, step);
  if (++unseen_ < kSteps || !(longest_ > 0.0)) return false;
  const double longest = longest_;
  unseen_ = 0;
  longest_ = 0.0;
  const double aside = t - longest / 64.0;
  try {
    change_ = dynamics_.solve_at(aside, motion.q, motion.Y, Pivots::kept).Ydot();
    change_ -= dynamics_.solve_at(t, motion.q, motion.Y, Pivots::kept).Ydot();
  } catch (const SolverError&) {
    return false;
  }
  if (!change_.allFinite()) return false;
  const double of_time = kTwoRoundOffs * t;
  noise_ = (of_time * longest / (t - aside) * change_.cwiseAbs()).cwiseMax(0.8 * noise_);  // laws rise and fall
  const VecX needed = wanted_of_motion();
  const auto of_speeds = needed.tail(layout_.n_Y()).array();
  const auto now = absolute_.segment(layout_.n_q(), layout_.n_Y()).array();
  if ((of_speeds <= 2.0 * now).all() && (now <= 2.0 * of_speeds).all()) return false;
  absolute_.head(needed.size()) = needed;
  return true;
}

/// Of places and speeds: what is asked for, but not less than what round-off and the noise of time leave.
VecX StepTolerances::wanted_of_motion() const {
  VecX wanted = asked_.head(layout_.n_q() + layout_.n_Y());
  for (const BodyIndex i : layout_.moving_bodies()) {
    layout_.a(wanted.head(layout_.n_q()), i) *= share_of_modes_;
    layout_.adot(wanted.tail(layout_.n_Y()), i) *= share_of_modes_;
  }
  wanted = wanted.cwiseMax(round_off_);
  wanted.tail(layout_.n_Y()) = wanted.tail(layout_.n_Y()).cwiseMax(noise_);
  return wanted;
}

/// A stiff spring turns the round-off of places into noise of accelerations. What that leaves in the speeds within
/// the time in which the spring acts is not asked for: steps against noise only become shorter and shorter. Nor is
/// what joints far from the origin leave of orientations, when the step is projected onto them.
VecX StepTolerances::measure_round_off(double t, const MotionState& motion) {
  const auto accelerations_at = [&](const VecX& q) -> VecX {
    return dynamics_.solve_at(t, q, motion.Y, Pivots::fresh).Ydot();
  };
  const VecX exact = accelerations_at(motion.q);
  const VecX units = dynamics_.equations().units();
  const VecX sizes = sizes_of_places(motion.q);
  VecX round_off(layout_.n_q() + layout_.n_Y());
  round_off << kTwoRoundOffs * sizes, VecX::Zero(layout_.n_Y());
  VecX noise = VecX::Zero(layout_.n_Y());
  for (int pattern = 1; pattern <= 3; ++pattern) {
    VecX q = motion.q;
    for (Eigen::Index k = 0; k < q.size(); ++k)
      q(k) += ((k * pattern) % 4 < 2 ? kTwoRoundOffs : -kTwoRoundOffs) * sizes(k);
    noise = noise.cwiseMax((accelerations_at(q) - exact).cwiseAbs());
  }
  const double square = noise.cwiseQuotient(units).lpNorm<Eigen::Infinity>() / kTwoRoundOffs;
  if (square > 0.0 && std::isfinite(square)) round_off.tail(layout_.n_Y()) = noise / std::sqrt(square);
  return round_off;
}

/// What round-off of the coordinates is relative to: they themselves, and the machine's length; of Euler parameters
/// 1, or how many lengths away from the origin the machine stands; of modes the largest vibration so far.
VecX StepTolerances::sizes_of_places(const VecX& q) const {
  VecX sizes = asked_.head(layout_.n_q()) / tolerance_.rtol;
  const double reach = reach_of(dynamics_.equations(), q);
  for (const BodyIndex i : layout_.moving_bodies()) {
    layout_.p(sizes, i).setConstant(reach);
    layout_.a(sizes, i) *= share_of_modes_;
  }
  return sizes.cwiseMax(q.cwiseAbs());
}

}  // namespace concord::cartesian
