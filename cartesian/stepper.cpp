#include "cartesian/stepper.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/error.h"

namespace concord::cartesian {

namespace {

struct Mode {
  double mass;       // kg, of a mode whose shape has no unit
  double frequency;  // rad/s, of the mode alone
};

Mode mode_of(const ModalData& modal, int k) {
  double mass = 0.0;
  for (int c = 0; c < 3; ++c) mass += modal.G(4 + 3 * k + c, 4 + 3 * k + c);
  return {mass, std::sqrt(std::abs(modal.stiffness(k, k)) / mass)};
}

constexpr double kRoundOff = std::numeric_limits<double>::epsilon();

}  // namespace

Stepper::Stepper(Equations& equations, const MotionState& start)
    : equations_(equations), motion_(start), has_regimes_(equations.applied().has_regimes()), event_(HUGE_VAL) {
  constexpr double kPart = 2e-2;  // of the time in which the machine moves or falls by its length
  const double rate = std::max(equations.natural_rate(), equations.largest_rate(0.0, start.Y));
  chatter_window_ = rate > 0.0 ? kPart / rate : HUGE_VAL;
}

double Stepper::step(double stop) {
  if (reached_ <= time_) {
    const double from = time_;
    const double value_before = event_function(from, motion_);
    advance(stop);
    event_ = has_regimes_ ? locate_event(from, value_before, stop) : HUGE_VAL;
  }
  if (event_ <= stop) {
    pass_event();
  } else {
    time_ = std::min(reached_, stop);
    set_motion_at(time_);
  }
  return time_;
}

void Stepper::begin_anew() {
  if (!remembers_multipliers()) return;
  equations_.update(time_, motion_.q, motion_.Y);
  equations_.solve(true);
  equations_.project(time_, motion_.q, motion_.Y);
  restart(time_);
  reached_ = time_;
}

/// How far tires and stops are inside their regimes.
double Stepper::event_function(double t, const MotionState& motion) {
  if (!has_regimes_) return HUGE_VAL;
  const AppliedForces::EventValue smallest = equations_.applied().event_function(t, motion.q, motion.Y);
  nearest_event_ = smallest.actor;
  return smallest.size;
}

double Stepper::event_function_at(double t) {
  set_motion_at(t);
  return event_function(t, motion_);
}

/// The time in the last step, which began at `from`, just past which a regime has ended; HUGE_VAL if none does. Looks
/// at several times, so that no regime that comes and goes within the step is missed; Illinois' rule between them.
double Stepper::locate_event(double from, double value_before, double stop) {  // (C59)
  constexpr int kSamples = 16;
  constexpr double kSharp = 1e-13;  // of the time of the run
  if (!(value_before >= 0.0)) return from;
  const double step = reached_ - from;
  if (step <= kSharp * stop) return HUGE_VAL;
  double inside = from;
  double outside = HUGE_VAL;
  for (int k = 1; k <= kSamples && outside == HUGE_VAL; ++k) {
    const double t = k == kSamples ? reached_ : from + step * k / kSamples;
    if (event_function(t, interpolate(t)) < 0.0) outside = t;
  }
  if (outside == HUGE_VAL) return HUGE_VAL;
  double past = event_function_at(outside);
  if (!(past < 0.0)) return HUGE_VAL;
  double before = value_before;
  int same_side = 0;  // how often in a row the root was found on the same side: positive inside, negative outside
  const double sharp = std::max(kSharp * stop, 64.0 * kRoundOff * outside);
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
  equations_.update(event_, motion_.q, motion_.Y);
  equations_.solve(true);
  equations_.project(event_, motion_.q, motion_.Y);
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
  if (time_ - events_since_ > chatter_window_) {
    events_since_ = time_;
    events_ = 0;
  }
  if (++events_ <= kMaxEvents) return;
  throw SolverError(
      fmt::format("cartesian: at t = {:.6g} s {} changes its regime without end: {} times within {:.2g} s; its "
                  "laws leave no motion there: look at its friction, its road's edges and its damping",
                  time_, equations_.applied().name_of_regime(nearest_event_), events_, time_ - events_since_));
}

VecX absolute_tolerances(const Equations& equations, const MotionState& start, Tolerance tolerance) {
  const Model& model = equations.model();
  const Layout& layout = equations.layout();
  const double length = model.length_scale();
  double speed = std::sqrt(model.gravity.norm() * length);
  for (int i = 1; i < layout.n_bodies(); ++i) {
    speed = std::max({speed, layout.v(start.Y, i).norm(), layout.omega(start.Y, i).norm() * length});
    for (int k = 0; k < layout.n_modes(i); ++k) {
      const Mode mode = mode_of(*model.bodies[i].modal, k);
      const double rate =
          std::max(std::abs(layout.adot(start.Y, i)(k)), mode.frequency * std::abs(layout.a(start.q, i)(k)));
      speed = std::max(speed, rate * std::sqrt(mode.mass / equations.inertia(i).mass()));
    }
  }
  constexpr double kStandstill = 1e-9;  // of the length in the time of the run: what closing leaves, and no motion
  const double least = length / tolerance.until;
  if (!(speed > kStandstill * least)) speed = std::max(equations.natural_rate() * length, least);
  double energy = 0.0;
  VecX scales(layout.n_q() + layout.n_Y() + 1);
  auto q = scales.head(layout.n_q());
  auto Y = scales.segment(layout.n_q(), layout.n_Y());
  for (int i = 1; i < layout.n_bodies(); ++i) {
    layout.r(q, i).setConstant(length);
    layout.p(q, i).setConstant(1.0);
    layout.v(Y, i).setConstant(speed);
    layout.omega(Y, i).setConstant(speed / length);
    energy += equations.inertia(i).mass() * speed * speed;
    for (int k = 0; k < layout.n_modes(i); ++k) {
      const Mode mode = mode_of(*model.bodies[i].modal, k);
      const double modal_speed = speed * std::sqrt(equations.inertia(i).mass() / mode.mass);
      layout.adot(Y, i)(k) = modal_speed;
      layout.a(q, i)(k) = modal_speed / std::max(mode.frequency, speed / length);
    }
  }
  scales(scales.size() - 1) = energy;
  return tolerance.rtol * scales;
}

}  // namespace concord::cartesian
