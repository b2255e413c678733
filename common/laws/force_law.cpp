#include "common/laws/force_law.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace concord {

namespace {

/// A regime ends so far beyond its border.
constexpr double kBeyondBorder = 1e-11;

/// Resistance of a stop that is pressed by p beyond its place, at the rate pdot, in a regime. It pushes: where its
/// damper would pull by more than its spring pushes, it has let go and is off (S31).
Resistance press(const SmoothStop& stop, StopRegime regime, double p, double pdot) {
  if (regime == StopRegime::off) return {};
  const bool full = regime == StopRegime::full;
  const double z = p / stop.width;
  const double share = full ? 1.0 : z * z * (3.0 - 2.0 * z);  // of the full stiffness and damping
  const double share_slope = full ? 0.0 : 6.0 * z * (1.0 - z) / stop.width;
  // The integral of the share over p.
  const double pressed = full ? p - 0.5 * stop.width : stop.width * z * z * z * (1.0 - 0.5 * z);
  return {stop.stiffness * pressed + stop.damping * share * pdot,
          stop.stiffness * share + stop.damping * share_slope * pdot, stop.damping * share};
}

/// The force over stiffness width and, below the width, over z^2: its sign says whether the stop pushes, and it goes
/// through zero with a slope wherever the force does.
double push_of(const SmoothStop& stop, double p, double pdot) {
  const double z = p / stop.width;
  const double damped = stop.damping * pdot / (stop.stiffness * stop.width);
  return z < 1.0 ? z * (1.0 - 0.5 * z) + (3.0 - 2.0 * z) * damped : z - 0.5 + damped;
}

StopRegime regime_of(const SmoothStop& stop, double p, double pdot) {
  if (p <= 0.0 || push_of(stop, p, pdot) <= 0.0) return StopRegime::off;
  return p < stop.width ? StopRegime::soft : StopRegime::full;
}

constexpr double kNoEnd = std::numeric_limits<double>::infinity();

std::array<double, 2> event_functions_of(const SmoothStop& stop, StopRegime regime, double p, double pdot) {
  const double z = p / stop.width;
  const double push = push_of(stop, p, pdot);
  switch (regime) {
    case StopRegime::off:
      return {z > 0.0 && push <= 0.0 ? -push : -z, kNoEnd};
    case StopRegime::soft:
      return {push, 1.0 - z};
    default:
      return {push, z - 1.0};
  }
}

Resistance& operator+=(Resistance& sum, const Resistance& other) {
  sum.force += other.force;
  sum.over_x += other.over_x;
  sum.over_xdot += other.over_xdot;
  return sum;
}

}  // namespace

ForceTable::ForceTable(std::vector<double> x, std::vector<double> force)
    : spline_(std::move(x), std::move(force)), first_(spline_.times().front()), last_(spline_.times().back()) {}

int ForceTable::piece_at(double x) const {
  if (x < first_) return kBelow;
  return x > last_ ? kAbove : spline_.piece_at(x);
}

double ForceTable::evaluate(int piece, double x) const {
  if (piece != kBelow && piece != kAbove) return spline_.evaluate(piece, x).f;
  const double end = nearest_end(piece);
  const TimeFunctionValue at = spline_.evaluate(end);
  return at.f + at.fdot * (x - end);
}

double ForceTable::slope(int piece, double x) const {
  const bool is_tangent = piece == kBelow || piece == kAbove;
  return is_tangent ? spline_.evaluate(nearest_end(piece)).fdot : spline_.evaluate(piece, x).fdot;
}

std::array<double, 2> ForceTable::event_functions(int piece, double x) const {
  const double length = last_ - first_;
  if (piece == kBelow) return {(first_ - x) / length, kNoEnd};
  if (piece == kAbove) return {(x - last_) / length, kNoEnd};
  const auto k = static_cast<std::size_t>(piece);
  return {(x - spline_.times()[k]) / length, (spline_.times()[k + 1] - x) / length};
}

Resistance evaluate_resistance(const ForceLaw& law, double x, double xdot) {
  return evaluate_resistance(law, regime_at(law, x, xdot), x, xdot);
}

Resistance evaluate_resistance(const ForceLaw& law, const LawRegime& regime, double x, double xdot) {
  const double stretch = x - law.free;
  Resistance sum{law.preload + law.stiffness * stretch + law.damping * xdot, law.stiffness, law.damping};
  if (const auto& table = law.spring_table) {
    const int piece = regime.spring_piece;
    sum += {table->evaluate(piece, stretch), table->slope(piece, stretch), 0.0};
  }
  if (const auto& table = law.damper_table) {
    const int piece = regime.damper_piece;
    sum += {table->evaluate(piece, xdot), 0.0, table->slope(piece, xdot)};
  }
  if (law.upper) sum += press(*law.upper, regime.upper, x - law.upper->at, xdot);
  if (law.lower) {
    const Resistance pushed = press(*law.lower, regime.lower, law.lower->at - x, -xdot);
    sum += {-pushed.force, pushed.over_x, pushed.over_xdot};
  }
  return sum;
}

LawRegime regime_at(const ForceLaw& law, double x, double xdot) {
  LawRegime regime;
  if (law.upper) regime.upper = regime_of(*law.upper, x - law.upper->at, xdot);
  if (law.lower) regime.lower = regime_of(*law.lower, law.lower->at - x, -xdot);
  if (law.spring_table) regime.spring_piece = law.spring_table->piece_at(x - law.free);
  if (law.damper_table) regime.damper_piece = law.damper_table->piece_at(xdot);
  return regime;
}

std::array<double, kLawEvents> event_functions_of(const ForceLaw& law, const LawRegime& regime, double x, double xdot) {
  std::array<double, kLawEvents> values;
  values.fill(kNoEnd);
  const auto take = [&values](std::size_t first, const std::array<double, 2>& both) {
    for (std::size_t k = 0; k < 2; ++k) values[first + k] = kBeyondBorder + both[k];
  };
  if (law.upper) take(0, event_functions_of(*law.upper, regime.upper, x - law.upper->at, xdot));
  if (law.lower) take(2, event_functions_of(*law.lower, regime.lower, law.lower->at - x, -xdot));
  if (law.spring_table) take(4, law.spring_table->event_functions(regime.spring_piece, x - law.free));
  if (law.damper_table) take(6, law.damper_table->event_functions(regime.damper_piece, xdot));
  return values;
}

double event_function_of(const ForceLaw& law, const LawRegime& regime, double x, double xdot) {
  const auto values = event_functions_of(law, regime, x, xdot);
  return *std::min_element(values.begin(), values.end());
}

double departure_of(const ForceLaw& law, const LawRegime& regime, double x, double xdot) {
  const LawRegime own = regime_at(law, x, xdot);
  if (regime == own) return 0.0;
  double size = 0.0;
  for (const auto& stop : {law.upper, law.lower}) {
    if (stop) size = std::max(size, stop->stiffness * stop->width);
  }
  for (const auto* table : {&law.spring_table, &law.damper_table}) {
    if (!*table) continue;
    for (const double force : (*table)->points().values()) size = std::max(size, std::abs(force));
  }
  const double departure =
      std::abs(evaluate_resistance(law, regime, x, xdot).force - evaluate_resistance(law, own, x, xdot).force);
  return departure > 0.0 ? departure / size : 0.0;
}

double evaluate_actuator(const ForceLaw& law, double t) {
  return law.actuator ? concord::evaluate(*law.actuator, t).f : 0.0;
}

}  // namespace concord
