#include "common/force_law.h"

#include <algorithm>

namespace concord {

namespace {

/// Resistance of a stop that is pressed by p beyond its place, at the rate pdot.
Resistance press(const SmoothStop& stop, double p, double pdot) {
  if (p <= 0.0) return {};
  const double z = std::min(p / stop.width, 1.0);
  const double share = z * z * (3.0 - 2.0 * z);  // of the full stiffness and damping
  const double share_slope = 6.0 * z * (1.0 - z) / stop.width;
  // The integral of the share over p.
  const double pressed = z < 1.0 ? stop.width * z * z * z * (1.0 - 0.5 * z) : p - 0.5 * stop.width;
  return {stop.stiffness * pressed + stop.damping * share * pdot,
          stop.stiffness * share + stop.damping * share_slope * pdot, stop.damping * share};
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
  const double stretch = x - law.free;
  Resistance sum{law.preload + law.stiffness * stretch + law.damping * xdot, law.stiffness, law.damping};
  if (law.spring_table) sum += {law.spring_table->evaluate(stretch), law.spring_table->slope(stretch), 0.0};
  if (law.damper_table) sum += {law.damper_table->evaluate(xdot), 0.0, law.damper_table->slope(xdot)};
  if (law.upper) sum += press(*law.upper, x - law.upper->at, xdot);
  if (law.lower) {
    const Resistance pushed = press(*law.lower, law.lower->at - x, -xdot);
    sum += {-pushed.force, pushed.over_x, pushed.over_xdot};
  }
  return sum;
}

double evaluate_actuator(const ForceLaw& law, double t) {
  return law.actuator ? concord::evaluate(*law.actuator, t).f : 0.0;
}

}  // namespace concord
