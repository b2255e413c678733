#include "common/force_law.h"

#include <algorithm>
#include <limits>

namespace concord {

namespace {

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

double margin_of(const SmoothStop& stop, StopRegime regime, double p, double pdot) {
  constexpr double kSlack = 1e-11;
  const double z = p / stop.width;
  const double push = push_of(stop, p, pdot);
  switch (regime) {
    case StopRegime::off:
      return kSlack + (z > 0.0 && push <= 0.0 ? -push : -z);
    case StopRegime::soft:
      return kSlack + std::min(push, 1.0 - z);
    default:
      return kSlack + std::min(push, z - 1.0);
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

double ForceTable::evaluate(double x) const {
  const double inside = std::clamp(x, first_, last_);
  const TimeFunctionValue at = spline_.evaluate(inside);
  return at.f + at.fdot * (x - inside);
}

double ForceTable::slope(double x) const { return spline_.evaluate(std::clamp(x, first_, last_)).fdot; }

Resistance evaluate_resistance(const ForceLaw& law, double x, double xdot) {
  return evaluate_resistance(law, regime_at(law, x, xdot), x, xdot);
}

Resistance evaluate_resistance(const ForceLaw& law, const LawRegime& regime, double x, double xdot) {
  const double stretch = x - law.free;
  Resistance sum{law.preload + law.stiffness * stretch + law.damping * xdot, law.stiffness, law.damping};
  if (law.spring_table) sum += {law.spring_table->evaluate(stretch), law.spring_table->slope(stretch), 0.0};
  if (law.damper_table) sum += {law.damper_table->evaluate(xdot), 0.0, law.damper_table->slope(xdot)};
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
  return regime;
}

double margin_of(const ForceLaw& law, const LawRegime& regime, double x, double xdot) {
  double margin = std::numeric_limits<double>::infinity();
  if (law.upper) margin = margin_of(*law.upper, regime.upper, x - law.upper->at, xdot);
  if (law.lower) margin = std::min(margin, margin_of(*law.lower, regime.lower, law.lower->at - x, -xdot));
  return margin;
}

double evaluate_actuator(const ForceLaw& law, double t) {
  return law.actuator ? concord::evaluate(*law.actuator, t).f : 0.0;
}

}  // namespace concord
