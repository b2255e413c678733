#pragma once

#include <variant>
#include <vector>

#include "common/types.h"

/// Laws of time that drive a joint coordinate: part of the statement of a problem, each with exact derivatives.
namespace concord {

/// A function of time and its first and second derivatives, in the coordinate's unit, per s and per s^2.
struct TimeFunctionValue {
  double f = 0.0;
  double fdot = 0.0;
  double fddot = 0.0;
};

/// f = start + speed t.
struct ConstantSpeed {
  double start = 0.0;
  double speed = 0.0;
};

/// f = sum of coefficients[k] t^k.
struct Polynomial {
  std::vector<double> coefficients;
};

/// f = offset + amplitude sin(frequency t + phase); frequency in rad/s.
struct Harmonic {
  double offset = 0.0;
  double amplitude = 0.0;
  double frequency = 0.0;
  double phase = 0.0;
};

/// From `from` before `t0` to `to` after `t1` along the polynomial of degree 7 whose first three derivatives vanish at
/// both ends, so that f'' is continuously differentiable.
struct SmoothStep {
  double t0 = 0.0;
  double t1 = 1.0;
  double from = 0.0;
  double to = 1.0;
};

/// Cubic spline through (times, values) with the not-a-knot condition at both ends; needs at least four points and
/// strictly rising times. Outside the table the end polynomials go on.
class SplineTable {
 public:
  SplineTable(std::vector<double> times, std::vector<double> values);

  [[nodiscard]] TimeFunctionValue evaluate(double t) const;
  /// The cubic between two points that holds at t: 0 before the second point, one more after each inner one.
  [[nodiscard]] int piece_at(double t) const;
  /// The same cubic, as if it went on for ever.
  [[nodiscard]] TimeFunctionValue evaluate(int piece, double t) const;
  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  [[nodiscard]] const std::vector<double>& values() const { return values_; }

 private:
  std::vector<double> times_;
  std::vector<double> values_;
  std::vector<double> slopes_;
  std::vector<double> curvatures_;
};

using TimeFunction = std::variant<ConstantSpeed, Polynomial, Harmonic, SmoothStep, SplineTable>;

/// Value and derivatives at time t [s].
TimeFunctionValue evaluate(const TimeFunction& function, double t);

}  // namespace concord
