#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/laws/time_function.h"

/// Laws of time and curves through points as the third opinion evaluates them: written from their statement in
/// data/format, without the evaluators that the solvers call. Derivatives are never written down: they follow from
/// the value by the rules of Moving.
namespace concord::compare {

/// A number that changes: its value and its first two rates.
struct Moving {
  double value = 0.0;
  double rate = 0.0;
  double rate_of_rate = 0.0;

  friend Moving operator+(const Moving& a, const Moving& b) {
    return {a.value + b.value, a.rate + b.rate, a.rate_of_rate + b.rate_of_rate};
  }
  friend Moving operator-(const Moving& a, const Moving& b) { return a + -1.0 * b; }
  friend Moving operator*(const Moving& a, const Moving& b) {
    return {a.value * b.value, a.rate * b.value + a.value * b.rate,
            a.rate_of_rate * b.value + 2.0 * a.rate * b.rate + a.value * b.rate_of_rate};
  }
  friend Moving operator*(double factor, const Moving& a) {
    return {factor * a.value, factor * a.rate, factor * a.rate_of_rate};
  }
  friend Moving operator+(double constant, const Moving& a) { return {constant + a.value, a.rate, a.rate_of_rate}; }
};

/// The sine of an angle that changes.
Moving sine(const Moving& angle);

/// The number itself, which changes at unit rate: f at it is {f, f', f''}.
inline Moving at_unit_rate(double x) { return {x, 1.0, 0.0}; }

/// The cubic spline through points whose third derivative is continuous at the second and the last but one of them
/// (not-a-knot). Beyond the points the polynomials of the end pieces go on. Found from the slopes at the points.
class Spline {
 public:
  /// At least four points, x strictly rising.
  Spline(const std::vector<double>& x, const std::vector<double>& y);
  explicit Spline(const SplineTable& table) : Spline(table.times(), table.values()) {}

  [[nodiscard]] Moving at(const Moving& x) const;
  [[nodiscard]] double first() const { return x_.front(); }
  [[nodiscard]] double last() const { return x_.back(); }

 private:
  std::vector<double> x_;
  std::vector<double> y_;
  /// Factors of the first three powers of the way from the point at one end of a piece.
  struct Powers {
    double slope;
    double bend;
    double twist;
  };
  std::vector<std::array<Powers, 2>> pieces_;  // from the left end, from the right one
};

/// A law of time. The statement must outlive it.
class LawOfTime {
 public:
  explicit LawOfTime(const TimeFunction& stated);

  /// f, f' and f'' at time t [s].
  [[nodiscard]] Moving at(double t) const;

 private:
  [[nodiscard]] Moving evaluate(const ConstantSpeed& law, const Moving& t) const;
  [[nodiscard]] Moving evaluate(const Polynomial& law, const Moving& t) const;
  [[nodiscard]] Moving evaluate(const Harmonic& law, const Moving& t) const;
  [[nodiscard]] Moving evaluate(const SmoothStep& law, const Moving& t) const;
  [[nodiscard]] Moving evaluate(const SplineTable& law, const Moving& t) const;

  const TimeFunction* stated_;
  std::optional<Spline> curve_;
};

}  // namespace concord::compare
