#include "cartesian/run/stepper.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cartesian/dynamics/state_scales.h"
#include "common/error.h"

namespace concord::cartesian {

namespace {

constexpr double kRoundOff = std::numeric_limits<double>::epsilon();
/// Into each step, for events.
constexpr Eigen::Index kEventSamples = 16;

}  // namespace

Stepper::Stepper(Dynamics& dynamics, const MotionState& start)
    : dynamics_(dynamics),
      equations_(dynamics.equations()),
      motion_(start),
      has_regimes_(equations_.applied().has_regimes()),
      event_(HUGE_VAL),
      event_samples_(equations_.applied().n_event_functions(), kEventSamples + 1) {
  note_rate(0.0);
}

/// Of the machine at the last update, at time t, where its motion is motion_.
void Stepper::note_rate(double t) {
  fastest_ = std::max({fastest_, natural_rate(equations_), largest_rate(equations_, t, motion_.Y)});
}

double Stepper::step(double stop, double limit) {
  if (stop <= time_) return time_;
  if (reached_ <= time_) {
    began_ = time_;
    looks_ = 0;
    if (has_regimes_) event_samples_.col(0) = event_functions(began_, motion_);
    advance(limit);
    largest_work_ = std::max(largest_work_, std::abs(motion_.work));
    event_ = has_regimes_ ? locate_event() : HUGE_VAL;
  }
  const double look = next_look();
  if (look < std::min({stop, event_, reached_})) {
    time_ = look;
    motion_ = interpolate(look);
  } else if (event_ <= stop) {
    pass_event();
  } else {
    time_ = std::min(reached_, stop);
    set_motion_at(time_);
  }
  return time_;
}

/// The next of the equal parts of the last step beyond the time reached.
double Stepper::next_look() {
  const auto time_of = [&](int k) { return began_ + (reached_ - began_) * k / parts_of_step(); };
  while (looks_ < parts_of_step() && time_of(looks_) <= time_) ++looks_;
  return looks_ < parts_of_step() ? time_of(looks_) : reached_;
}

void Stepper::begin_anew() {
  if (!remembers_multipliers()) return;
  close_motion(time_);
  restart(time_);
  reached_ = time_;
}

/// Brings motion_, which is at time t, onto the constraints.
void Stepper::close_motion(double t) {
  const Solution& solution = dynamics_.solve_at(t, motion_.q, motion_.Y, Pivots::fresh);
  dynamics_.project(solution, t, motion_.q, motion_.Y);
}

/// How far tires and stops are inside their regimes: all, and the smallest.
const VecX& Stepper::event_functions(double t, const MotionState& motion) {
  return equations_.applied().event_functions(equations_.moving_constraints(), t, motion.q, motion.Y);
}

double Stepper::event_function(double t, const MotionState& motion) {
  if (!has_regimes_) return HUGE_VAL;
  Eigen::Index nearest = 0;
  const double smallest = event_functions(t, motion).minCoeff(&nearest);
  nearest_event_ = equations_.applied().owner_of_event(nearest);
  return smallest;
}

double Stepper::event_function_at(double t) {
  set_motion_at(t);
  return event_function(t, motion_);
}

/// A time of the last step where an event function is negative; HUGE_VAL if there is none.
/// Looks at equal times, and for the minimum of each function that may dip below zero between two of them.
double Stepper::find_outside() {
  const double step = reached_ - began_;
  const auto time_of = [&](Eigen::Index k) {
    return k == kEventSamples ? reached_ : began_ + step * double(k) / kEventSamples;
  };
  for (Eigen::Index k = 1; k <= kEventSamples; ++k) {
    const double t = time_of(k);
    const MotionState& motion = interpolate(t);
    event_samples_.col(k) = event_functions(t, motion);
    if (event_samples_.col(k).minCoeff() < 0.0) return t;
  }
  for (Eigen::Index function = 0; function < event_samples_.rows(); ++function) {
    for (Eigen::Index k = 1; k < kEventSamples; ++k) {
      const auto values = event_samples_.row(function);
      const double fall = values(k - 1) - values(k);
      const double rise = values(k + 1) - values(k);
      if (!(fall >= 0.0 && rise >= 0.0) || values(k) > std::max(fall, rise)) continue;
      const double outside = find_minimum(function, time_of(k - 1), time_of(k + 1));
      if (outside != HUGE_VAL) return outside;
    }
  }
  return HUGE_VAL;
}

/// A time between two of the last step where an event function is negative, by the golden section; HUGE_VAL if its
/// minimum is not.
double Stepper::find_minimum(Eigen::Index function, double low, double high) {
  constexpr double kGolden = 0.6180339887498949;
  constexpr int kSections = 40;
  const auto value = [&](double t) {
    const MotionState& motion = interpolate(t);
    return event_functions(t, motion)(function);
  };
  double left = high - kGolden * (high - low);
  double right = low + kGolden * (high - low);
  double of_left = value(left);
  double of_right = value(right);
  for (int k = 0; k < kSections; ++k) {
    if (of_left < 0.0) return left;
    if (of_right < 0.0) return right;
    if (of_left < of_right) {
      high = right;
      right = left;
      of_right = of_left;
      left = high - kGolden * (high - low);
      of_left = value(left);
    } else {
      low = left;
      left = right;
      of_left = of_right;
      right = low + kGolden * (high - low);
      of_right = value(right);
    }
  }
  return HUGE_VAL;
}

/// The time in the last step, at whose beginning event_samples_ has the event functions, just past which a regime has
/// ended; HUGE_VAL if none does. Illinois' rule between times inside and outside.
double Stepper::locate_event() {    // (C64)
  constexpr double kSharp = 1e-13;  // of the time reached
  const double value_before = event_samples_.col(0).minCoeff();
  if (!(value_before >= 0.0)) return began_;
  if (reached_ - began_ <= kSharp * reached_) return HUGE_VAL;
  double inside = began_;
  double outside = find_outside();
  if (outside == HUGE_VAL) return HUGE_VAL;
  double past = event_function_at(outside);
  if (!(past < 0.0)) return HUGE_VAL;
  double before = value_before;
  int same_side = 0;  // how often in a row the root was found on the same side: positive inside, negative outside
  const double sharp = std::max(kSharp * reached_, 64.0 * kRoundOff * outside);
  while (outside - inside > sharp) {
    const bool halve = !(before > 0.0) || std::abs(same_side) > 2;
    const double part = halve ? 0.5 : before / (before - past);
    const double t = std::clamp(inside + part * (outside - inside), inside + 0.5 * sharp, outside - 0.5 * sharp);
    const double found = event_function_at(t);
    if (found < 0.0) {
      outside = t;
      past = found;
      same_side = std::min(same_side - 1, -1);
      if (same_side < -1) before *= 0.5;
    } else {
      inside = t;
      before = found;
      same_side = std::max(same_side + 1, 1);
      if (same_side > 1) past *= 0.5;
    }
  }
  return outside;
}

void Stepper::pass_event() {
  set_motion_at(event_);
  (void)event_function(event_, motion_);  // names the tire or the stop
  close_motion(event_);
  equations_.applied().freeze_regimes(false);
  equations_.update(event_, motion_.q, motion_.Y);
  equations_.applied().freeze_regimes(true);
  restart(event_);
  time_ = reached_ = event_;
  event_ = HUGE_VAL;
  refuse_chatter();
}

void Stepper::refuse_chatter() {
  constexpr int kMaxEvents = 200;
  constexpr double kPart = 2e-2;  // of the time in which the machine moves or falls by its length
  note_rate(time_);
  if (fastest_ * (time_ - events_since_) > kPart) {
    events_since_ = time_;
    events_ = 0;
  }
  if (++events_ <= kMaxEvents) return;
  throw SolverError(
      fmt::format("cartesian: at t = {:.6g} s {} changes its regime without end: {} times within {:.2g} s, in which "
                  "the machine hardly moves; its laws leave no motion there: look at its friction, its road's edges "
                  "and its damping",
                  time_, equations_.applied().name_of_regime(nearest_event_), events_, time_ - events_since_));
}

}  // namespace concord::cartesian
