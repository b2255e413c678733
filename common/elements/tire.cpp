#include "common/elements/tire.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace concord {

namespace {

/// V, which is regular at standstill.
double slip_speed(const Tire& tire, const TireContact& contact) { return std::hypot(contact.V_x, tire.speed_scale); }

/// Slip forces below the friction limit.
TireForces evaluate_linear(const Tire& tire, const TireContact& contact) {
  const double V = slip_speed(tire, contact);
  return {tire.stiffness * contact.delta + tire.damping * contact.deltadot, -tire.slip_stiffness * contact.s_x / V,
          -tire.cornering_stiffness * contact.V_y / V};
}

/// The linear slip forces along those with which sliding began.
double along(const TireRegime& regime, const TireForces& linear) {
  return regime.along_x * linear.F_x + regime.along_y * linear.F_y;
}

}  // namespace

TireForces evaluate(const Tire& tire, const TireRegime& regime, const TireContact& contact) {
  if (!regime.pushes) return {};
  TireForces forces = evaluate_linear(tire, contact);
  if (!regime.slides) return forces;
  const double turned = std::min(along(regime, forces), 0.0);
  forces.F_x -= 2.0 * turned * regime.along_x;
  forces.F_y -= 2.0 * turned * regime.along_y;
  const double scale = tire.friction * forces.N / std::hypot(forces.F_x, forces.F_y);
  forces.F_x *= scale;
  forces.F_y *= scale;
  return forces;
}

TireRegime regime_at(const Tire& tire, const TireContact& contact) {
  TireRegime regime;
  regime.stretch = stretch_at(*tire.road, contact.x);
  regime.touches = contact.delta > 0.0;
  if (!regime.touches) return regime;
  const TireForces forces = evaluate_linear(tire, contact);
  regime.pushes = forces.N > 0.0;
  const double size = std::hypot(forces.F_x, forces.F_y);
  regime.slides = regime.pushes && size > tire.friction * forces.N;
  if (regime.slides) {
    regime.along_x = forces.F_x / size;
    regime.along_y = forces.F_y / size;
  }
  return regime;
}

std::array<double, kTireEvents> event_functions_of(const Tire& tire, const TireRegime& regime,
                                                   const TireContact& contact) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const auto holds = [](bool inside, double value) { return inside ? value : -value; };
  std::array<double, kTireEvents> values{kNone, kNone, kNone, kNone, kNone, kNone};
  auto& [behind, ahead, touching, pushing, sliding, turning] = values;
  const auto [begin, end] = edges_of(*tire.road, regime.stretch);
  behind = (contact.x - begin) / tire.radius;
  ahead = (end - contact.x) / tire.radius;
  touching = holds(regime.touches, contact.delta / tire.radius);
  if (!regime.touches) return values;
  const double force_scale = tire.stiffness * tire.radius;
  const TireForces forces = evaluate_linear(tire, contact);
  pushing = holds(regime.pushes, forces.N / force_scale);
  if (!regime.pushes) return values;
  // Times V, so that slip forces do not level off, and what a look sees of the function tells where it goes.
  const double speed = slip_speed(tire, contact) / tire.speed_scale;
  const double beyond = std::hypot(forces.F_x, forces.F_y) - tire.friction * forces.N;
  sliding = holds(regime.slides, speed * beyond / force_scale);
  const bool has_direction = regime.along_x != 0.0 || regime.along_y != 0.0;
  if (regime.slides && has_direction) turning = speed * along(regime, forces) / force_scale;
  return values;
}

double event_function_of(const Tire& tire, const TireRegime& regime, const TireContact& contact) {
  const auto values = event_functions_of(tire, regime, contact);
  return *std::min_element(values.begin(), values.end());
}

}  // namespace concord
