#include "relative/run/regime_events.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace concord::relative {

namespace {

constexpr int kMostTrials = 100;
constexpr std::size_t kMostEvents = 200;
constexpr double kTinyTime = 1e-4;  // of the run's
constexpr double kTinyWay = 1e-4;   // of the machine's sizes

double round_off_of_time(double t) { return 8.0 * std::numeric_limits<double>::epsilon() * t; }

}  // namespace

RegimeEvents::RegimeEvents(AppliedForces& forces, ApplyForces apply, Stepper& stepper, VecX sizes, double until)
    : forces_(&forces),
      apply_(std::move(apply)),
      stepper_(&stepper),
      until_(until),
      within_(stepper.y()),
      sizes_(std::move(sizes)),
      at_event_(within_.head(sizes_.size())) {
  look_.values = VecX::Zero(forces.n_event_functions());
  looks_.fill(look_);
}

RegimeEvents::~RegimeEvents() { forces_->free_regimes(); }

void RegimeEvents::set_regimes() {
  forces_->free_regimes();
  take_event_functions(stepper_->t(), stepper_->y(), looks_.front().values);
  forces_->freeze_regimes();
  departed_ = false;
}

void RegimeEvents::step(double t_end) {
  const double t_before = stepper_->t();
  stepper_->step(t_end);
  take_event_functions(stepper_->t(), stepper_->y(), looks_.back().values);
  const auto departed = forces_->departed_contact();
  const double step = stepper_->t() - t_before;
  const std::optional<Bracket> bracket = find_bracket(t_before, step);
  if (!bracket) {
    require_held_regimes(departed);
    looks_.front().values = looks_.back().values;
    return;
  }
  approach(*bracket);
  if (least_event_function() < 0.0) require_progress();
  set_regimes();
  const double t = stepper_->t();
  stepper_->restart(std::min(step, std::max(t_end - t, round_off_of_time(t))));
}

void RegimeEvents::take_event_functions(double t, const Eigen::Ref<const VecX>& y, VecX& values) {
  apply_(t, y);
  forces_->write_event_functions(values);
}

double RegimeEvents::least_event_function() {
  take_event_functions(stepper_->t(), stepper_->y(), look_.values);
  return look_.least();
}

void RegimeEvents::take_look(double t_before, double at, Look& look) {
  look.at = at;
  stepper_->interpolate(t_before + at, within_);
  take_event_functions(t_before + at, within_, look.values);
}

/// From the begin of the step, where the state is exact: what lies within is interpolated and may be off.
RegimeEvents::Bracket RegimeEvents::up_to(double at, double value) const {
  return {0.0, std::max(0.0, looks_.front().least()), at, value};
}

/// Between which times of the last step, from its begin, a regime ends; nothing if none does. Within the step an
/// event function may dip below zero and come back; where chords allow it, the step is looked into there.
std::optional<RegimeEvents::Bracket> RegimeEvents::find_bracket(double t_before, double step) {
  constexpr double kShortest = 1e-9;  // of the run: nothing dips that moves so little
  constexpr std::array kParts{1.0 / 64.0, 0.5, 1.0 - 1.0 / 64.0};
  Look& begin = looks_.front();
  Look& end = looks_.back();
  begin.at = 0.0;
  end.at = step;
  if (step <= kShortest * until_) return end.least() < 0.0 ? std::optional(up_to(end.at, end.least())) : std::nullopt;
  for (std::size_t k = 0; k < kParts.size(); ++k) take_look(t_before, kParts[k] * step, looks_[k + 1]);
  for (std::size_t k = 1; k < looks_.size(); ++k) {
    if (looks_[k].least() < 0.0) return up_to(looks_[k].at, looks_[k].least());
  }
  return find_dip(t_before);
}

/// The same where no look into the step finds an end: between looks, function by function.
std::optional<RegimeEvents::Bracket> RegimeEvents::find_dip(double t_before) {
  for (Eigen::Index function = 0; function < look_.values.size(); ++function) {
    for (std::size_t k = 0; k + 3 < looks_.size(); ++k) {
      const Point inside = point(looks_[k + 1], function);
      const std::array<Point, 4> around{point(looks_[k], function), inside, point(looks_[k + 2], function),
                                        point(looks_[k + 3], function)};
      if (const auto found = follow_dip(t_before, around, function)) {
        return up_to(found->at, found->value);
      }
    }
  }
  return std::nullopt;
}

/// Where the chords that reach in from both sides meet between the two points in the middle, and not too near to
/// either, if that is below zero but for what such functions bend the other way (R76).
std::optional<RegimeEvents::Point> RegimeEvents::lowest_possible(const std::array<Point, 4>& around) {
  constexpr double kBend = 0.05;      // of the larger value beside
  constexpr double kNotNearer = 0.1;  // of the way between them: both sides come nearer
  const auto& [a, b, c, d] = around;
  const double fall = (b.value - a.value) / (b.at - a.at);
  const double rise = (d.value - c.value) / (d.at - c.at);
  if (!(fall < 0.0 && rise > 0.0)) return std::nullopt;
  const double at = (b.value - c.value - fall * b.at + rise * c.at) / (rise - fall);
  const double value = b.value + fall * (at - b.at);
  if (!(at > b.at && at < c.at && value < kBend * std::max(b.value, c.value))) return std::nullopt;
  const double margin = kNotNearer * (c.at - b.at);
  return Point{std::clamp(at, b.at + margin, c.at - margin), value};
}

/// Whether one event function dips below zero between the two points in the middle: looks there as long as it may.
/// The last point inside and the first outside.
std::optional<RegimeEvents::Point> RegimeEvents::follow_dip(double t_before, std::array<Point, 4> around,
                                                            Eigen::Index function) {
  constexpr int kMostLooks = 30;
  std::optional<Point> lowest = lowest_possible(around);
  for (int k = 0; k < kMostLooks && lowest; ++k) {
    take_look(t_before, lowest->at, look_);
    const Point found = point(look_, function);
    const auto [a, b, c, d] = around;
    if (found.value < 0.0) return found;
    around = {a, b, found, c};
    lowest = lowest_possible(around);
    const std::array<Point, 4> right{b, found, c, d};
    const std::optional<Point> lowest_right = lowest_possible(right);
    if (!lowest_right || (lowest && lowest->value <= lowest_right->value)) continue;
    around = right;
    lowest = lowest_right;
  }
  return std::nullopt;
}

/// Where to look next: where the secant vanishes, but not closer to an end than the tolerance (R75).
double RegimeEvents::guess(const Bracket& b, double tolerance) {
  const double part = b.value_inside / (b.value_inside - b.value_outside);
  return std::clamp(b.inside + part * (b.outside - b.inside), b.inside + tolerance, b.outside - tolerance);
}

/// Finds the step that ends just outside and leaves its state in the stepper: by secants, the value at an end that
/// stays halved (the Illinois method), and in the middle after a secant that did not halve the bracket. The event
/// function is the smallest of several: where another one rests on its border, secants alone would not get to the end.
void RegimeEvents::approach(Bracket b) {
  const double tolerance = std::max(1e-13 * until_, round_off_of_time(stepper_->t()));
  double made = 0.0;
  int last_side = 0;
  bool bisects = false;
  for (int trial = 0; trial < kMostTrials && b.outside - b.inside > 2.0 * tolerance; ++trial) {
    const double length = b.outside - b.inside;
    const double step = bisects ? b.inside + 0.5 * length : guess(b, tolerance);
    stepper_->step_exactly(step);
    made = step;
    const double found = least_event_function();
    const int side = found < 0.0 ? 1 : -1;
    if (side > 0) {
      b.outside = step;
      b.value_outside = found;
      if (last_side == side) b.value_inside *= 0.5;
    } else {
      b.inside = step;
      b.value_inside = found;
      if (last_side == side) b.value_outside *= 0.5;
    }
    last_side = side;
    bisects = !bisects && b.outside - b.inside > 0.5 * length;
  }
  if (made != b.outside) stepper_->step_exactly(b.outside);
}

/// At the end of a step that none of the event functions cuts short: the forces are those of the laws.
void RegimeEvents::require_held_regimes(const std::optional<AppliedForces::Contact>& departed) {
  if (departed && departed_) {
    throw SolverError(
        fmt::format("at t = {:.6g} s the force of {} is not what its law says: the end of its regime was missed, which "
                    "is a fault of the program",
                    stepper_->t(), departed->name()));
  }
  departed_ = departed.has_value();
}

/// Refuses regimes that take turns in no time and on no way: a wheel that bounces on for long changes them as often.
void RegimeEvents::require_progress() {
  const double t = stepper_->t();
  const auto q = stepper_->y().head(sizes_.size());
  const double step = sizes_.size() > 0 ? (q - at_event_).cwiseQuotient(sizes_).lpNorm<Eigen::Infinity>() : 0.0;
  at_event_ = q;
  events_.push_back({t, step + (events_.empty() ? 0.0 : events_.back().way)});
  if (events_.size() <= kMostEvents) return;
  const Event& first = events_[events_.size() - 1 - kMostEvents];
  const double way = events_.back().way - first.way;
  if (t - first.t > kTinyTime * until_ || way > kTinyWay) return;
  throw SolverError(
      fmt::format("the contact of {} changes its regime {} times within {:.1e} s, in which the machine moves by {:.1e} "
                  "of its size: its laws drive it back from both sides; change what meets there: an edge of the road, "
                  "a stop, friction or damping",
                  forces_->least_contact(), kMostEvents, t - first.t, way));
}

}  // namespace concord::relative
