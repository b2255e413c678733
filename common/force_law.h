#pragma once

#include <optional>
#include <vector>

#include "common/time_function.h"

/// Scalar force laws: part of the statement of a machine. Each solver turns them into generalized forces by itself.
namespace concord {

/// A force over a stretch or over its rate: a cubic spline through the points inside the table, the tangent lines at
/// its ends outside (S30).
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

/// A soft stop that begins to resist at `at`. Pressed by p = x - at (a lower stop: at - x), with z = p / width up to 1
/// and the share s = z^2 (3 - 2 z), it pushes with stiffness times the integral of s over p, plus damping s pdot, if
/// this is positive, else not at all: a stop never pulls. The spring's part is twice continuously differentiable, the
/// damper's once; where a damped stop lets go, in the middle of the rebound, the force goes through zero with a kink.
/// Resists growth beyond `at` (an upper stop) or fall below it (a lower one).
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

Resistance evaluate_resistance(const ForceLaw& law, double x, double xdot);  // (S29)

/// How a stop acts: not at all (it is not pressed, or has let go), with the share of a stop that is not pressed by its
/// width, or in full. Between two of them lies a kink of some derivative of the force.
enum class StopRegime { off, soft, full };

/// Of both stops of a law. An integrator keeps the regime during a step, as if its formulas went on for ever, and ends
/// the step where the regime ends, as with tires.
struct LawRegime {
  StopRegime lower = StopRegime::off;
  StopRegime upper = StopRegime::off;
};

/// Resistance with the stops in a given regime.
Resistance evaluate_resistance(const ForceLaw& law, const LawRegime& regime, double x, double xdot);

/// The regime that the stops are in by themselves.
LawRegime regime_at(const ForceLaw& law, double x, double xdot);

/// How far the stops are inside a regime: positive inside, through zero where it ends; in widths of the stop, or in
/// forces over stiffness times width. The smaller of both stops'; infinite without stops. A regime ends 1e-11 beyond
/// its border, where its formulas still hold to round-off, so that a stop that rests on a border does not chatter.
double margin_of(const ForceLaw& law, const LawRegime& regime, double x, double xdot);

[[nodiscard]] inline bool has_stops(const ForceLaw& law) { return law.lower.has_value() || law.upper.has_value(); }

/// Force of the actuator at time t; zero if there is none.
double evaluate_actuator(const ForceLaw& law, double t);

}  // namespace concord
