#include "compare/audit/law_of_force.h"

#include <algorithm>
#include <cmath>

namespace concord::compare {

double share_of(double z) { return z >= 1.0 ? 1.0 : z * z * (3.0 - 2.0 * z); }

namespace {

std::optional<Spline> curve_of(const std::optional<ForceTable>& table) {
  if (!table) return std::nullopt;
  return Spline(table->points());
}

/// Between the points the curve, beyond them the tangent at the end.
double read(const Spline& table, double x) {
  if (x >= table.first() && x <= table.last()) return table.at({x, 0.0, 0.0}).value;
  const double end = x < table.first() ? table.first() : table.last();
  const Moving tangent = table.at(at_unit_rate(end));
  return tangent.value + tangent.rate * (x - end);
}

/// Of a stop that is pressed by p at the rate pdot. The spring's part is the stiffness that it has, summed over p: up
/// to the width by Gauss' rule of two points, which is exact for the share's cubic. It pushes, and never pulls.
double push(const SmoothStop& stop, double p, double pdot) {
  if (p <= 0.0) return 0.0;
  const double soft = std::min(p, stop.width);
  const double half_apart = 0.5 / std::sqrt(3.0);
  const double summed =
      0.5 * soft *
      (share_of((0.5 - half_apart) * soft / stop.width) + share_of((0.5 + half_apart) * soft / stop.width));
  const double spring = stop.stiffness * (summed + std::max(0.0, p - stop.width));
  return std::max(0.0, spring + stop.damping * share_of(p / stop.width) * pdot);
}

}  // namespace

LawOfForce::LawOfForce(const ForceLaw& stated)
    : stated_(&stated), spring_(curve_of(stated.spring_table)), damper_(curve_of(stated.damper_table)) {
  if (stated.actuator) actuator_.emplace(*stated.actuator);
}

double LawOfForce::resistance(double x, double xdot) const {
  const double stretch = x - stated_->free;
  double sum = stated_->preload + stated_->stiffness * stretch + stated_->damping * xdot;
  if (spring_) sum += read(*spring_, stretch);
  if (damper_) sum += read(*damper_, xdot);
  if (stated_->upper) sum += push(*stated_->upper, x - stated_->upper->at, xdot);
  if (stated_->lower) sum -= push(*stated_->lower, stated_->lower->at - x, -xdot);
  return sum;
}

}  // namespace concord::compare
