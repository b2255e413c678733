#pragma once

#include <optional>
#include <vector>

#include "common/time_function.h"

/// Scalar force laws: part of the statement of a machine. Each solver turns them into generalized forces by itself.
namespace concord {

/// A force over a stretch or over its rate: a cubic spline through the points inside the table, the tangent lines at
/// its ends outside.
class ForceTable {
 public:
  /// At least four points, x strictly rising.
  ForceTable(std::vector<double> x, std::vector<double> force);

  [[nodiscard]] double evaluate(double x) const;
  [[nodiscard]] double slope(double x) const;
  /// The points as they were given.
  [[nodiscard]] const SplineTable& points() const { return spline_; }

 private:
  SplineTable spline_;
  double first_;
  double last_;
};

/// A soft stop that begins to resist at `at`, with full stiffness after `width`; the spring's part is twice
/// continuously differentiable, the damper's once. Resists growth beyond `at` (an upper stop) or fall below it (a lower
/// one).
struct SmoothStop {
  double at = 0.0;         // m or rad
  double stiffness = 0.0;  // N/m or N m/rad
  double damping = 0.0;    // N s/m or N m s/rad, in full after `width`
  double width = 0.0;      // m or rad, positive
};

/// What resists the growth of a coordinate x [m or rad] with rate xdot: a spring and damper in parallel, straight lines
/// plus tables plus stops. Positive = tension: it pulls x to become smaller. The actuator's force is a law of time of
/// its own; its sign belongs to the element that has it.
struct ForceLaw {
  double stiffness = 0.0;
  double damping = 0.0;
  double free = 0.0;                       // x at which the linear spring and the table of x rest
  double preload = 0.0;                    // tension at x = free
  std::optional<ForceTable> spring_table;  // over x - free
  std::optional<ForceTable> damper_table;  // over xdot
  std::optional<SmoothStop> lower;
  std::optional<SmoothStop> upper;
  std::optional<TimeFunction> actuator;
};

/// Resistance and its slopes over x and xdot, without the actuator.
struct Resistance {
  double force = 0.0;
  double over_x = 0.0;
  double over_xdot = 0.0;
};

Resistance evaluate_resistance(const ForceLaw& law, double x, double xdot);

/// Force of the actuator at time t; zero if there is none.
double evaluate_actuator(const ForceLaw& law, double t);

}  // namespace concord
