#pragma once

#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "common/laws/time_function.h"

/// Scalar force laws: part of the statement of a machine. Each solver turns them into generalized forces by itself.
namespace concord {

/// A force over a stretch or over its rate: a cubic spline through the points inside the table, the tangent lines at
/// its ends outside (S30).
class ForceTable {
 public:
  /// At least four points, x strictly rising.
  ForceTable(std::vector<double> x, std::vector<double> force);

  [[nodiscard]] double evaluate(double x) const { return evaluate(piece_at(x), x); }
  [[nodiscard]] double slope(double x) const { return slope(piece_at(x), x); }
  /// The points as they were given.
  [[nodiscard]] const SplineTable& points() const { return spline_; }

  /// The formula that holds at x: kBelow and kAbove the tangent lines, else a cubic of the spline.
  [[nodiscard]] int piece_at(double x) const;
  /// Force and slope by one formula, as if it went on for ever.
  [[nodiscard]] double evaluate(int piece, double x) const;
  [[nodiscard]] double slope(int piece, double x) const;
  /// How far x is inside the piece, in parts of the table's length; negative outside.
  [[nodiscard]] std::array<double, 2> event_functions(int piece, double x) const;

 private:
  static constexpr int kBelow = -1;
  static constexpr int kAbove = std::numeric_limits<int>::max();
  [[nodiscard]] double nearest_end(int piece) const { return piece == kBelow ? first_ : last_; }

  SplineTable spline_;
  double first_;
  double last_;
};

/// A soft stop that begins to resist at `at`. Pressed by p = x - at (a lower stop: at - x), with z = p / width up to 1
/// and the share s = z^2 (3 - 2 z), it pushes with stiffness times the integral of s over p, plus damping s pdot, if
/// this is positive, else not at all: a stop never pulls. The spring's part is twice continuously differentiable, the
/// damper's once; where a damped stop lets go, in the middle of the rebound, the force passes zero with a jump of its
/// rate. Resists growth beyond `at` (an upper stop) or fall below it (a lower one).
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
/// width, or in full. Between two of them some derivative of the force jumps.
enum class StopRegime { off, soft, full };

/// Of both stops of a law, and the pieces of its tables: between two pieces the third derivative jumps. An integrator
/// keeps the regime during a step, as if its formulas went on for ever, and ends the step where the regime ends, as
/// with tires.
struct LawRegime {
  StopRegime lower = StopRegime::off;
  StopRegime upper = StopRegime::off;
  int spring_piece = 0;
  int damper_piece = 0;
  bool operator==(const LawRegime& other) const {
    return lower == other.lower && upper == other.upper && spring_piece == other.spring_piece &&
           damper_piece == other.damper_piece;
  }
};

/// Resistance with the stops and tables in a given regime.
Resistance evaluate_resistance(const ForceLaw& law, const LawRegime& regime, double x, double xdot);

/// The regime that the stops and tables are in by themselves.
LawRegime regime_at(const ForceLaw& law, double x, double xdot);

/// How far stops and tables are inside a regime, by the ends that a regime may have: two each of the upper stop, the
/// lower stop, the spring's and the damper's table. Positive inside, through zero where it ends; in widths of the stop,
/// in forces over stiffness times width, or in lengths of the table; infinite without stops and tables. A regime ends
/// 1e-11 beyond its border, where its formulas still hold to round-off, so that a spring that rests on a border does
/// not chatter.
inline constexpr int kLawEvents = 8;
std::array<double, kLawEvents> event_functions_of(const ForceLaw& law, const LawRegime& regime, double x, double xdot);
/// The smallest of them.
double event_function_of(const ForceLaw& law, const LawRegime& regime, double x, double xdot);

/// How far the force in a regime departs from the law's own at x and xdot: as a part of stiffness times width of a stop
/// and of the largest force of a table. Zero in the regime that the law is in by itself.
double departure_of(const ForceLaw& law, const LawRegime& regime, double x, double xdot);

/// What departs further from the law at the ends of two steps in a row has missed the end of its regime. At the end of
/// one step it may: a damped tire lands with a jump, 1e-11 of its radius before its regime ends.
inline constexpr double kLargestDeparture = 1e-7;

/// Whether the law has more than one regime.
[[nodiscard]] inline bool has_regimes(const ForceLaw& law) {
  return law.lower || law.upper || law.spring_table || law.damper_table;
}

/// Force of the actuator at time t; zero if there is none.
double evaluate_actuator(const ForceLaw& law, double t);

}  // namespace concord
