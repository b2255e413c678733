#pragma once

#include <Eigen/Core>
#include <cmath>

#include "common/types.h"

/// Forward automatic differentiation for joints that are given by functions. A type of our own instead of Eigen's
/// nested AutoDiffScalar: its arithmetic returns plain numbers, never expressions that refer to their operands, so that
/// `auto` is safe on a page; and a second derivative is needed along one motion only, not a whole Hessian.
namespace concord::joints {

/// A number with its exact derivatives at a moment of a motion: over six directions, and the first and second one along
/// the motion.
struct Jet {
  double value = 0.0;
  Vec6 gradient = Vec6::Zero();
  double rate = 0.0;
  double rate_of_rate = 0.0;

  Jet() = default;
  /// A constant.
  Jet(double constant) : value(constant) {}  // NOLINT(google-explicit-constructor): numbers mix with jets on a page
  Jet(double at, const Vec6& over, double along, double twice_along)
      : value(at), gradient(over), rate(along), rate_of_rate(twice_along) {}

  Jet& operator+=(const Jet& other) { return *this = *this + other; }
  Jet& operator-=(const Jet& other) { return *this = *this - other; }
  Jet& operator*=(const Jet& other) { return *this = *this * other; }
  Jet& operator/=(const Jet& other) { return *this = *this / other; }

  friend Jet operator-(const Jet& a) { return {-a.value, -a.gradient, -a.rate, -a.rate_of_rate}; }
  friend Jet operator+(const Jet& a, const Jet& b) {
    return {a.value + b.value, a.gradient + b.gradient, a.rate + b.rate, a.rate_of_rate + b.rate_of_rate};
  }
  friend Jet operator-(const Jet& a, const Jet& b) { return a + (-b); }
  friend Jet operator*(const Jet& a, const Jet& b) {
    return {a.value * b.value, a.value * b.gradient + b.value * a.gradient, a.value * b.rate + b.value * a.rate,
            a.value * b.rate_of_rate + 2.0 * a.rate * b.rate + b.value * a.rate_of_rate};
  }
  friend Jet operator/(const Jet& a, const Jet& b) {
    const double over = 1.0 / b.value;
    return a * b.through(over, -over * over, 2.0 * over * over * over);
  }

  friend bool operator<(const Jet& a, const Jet& b) { return a.value < b.value; }
  friend bool operator>(const Jet& a, const Jet& b) { return a.value > b.value; }
  friend bool operator<=(const Jet& a, const Jet& b) { return a.value <= b.value; }
  friend bool operator>=(const Jet& a, const Jet& b) { return a.value >= b.value; }
  friend bool operator==(const Jet& a, const Jet& b) { return a.value == b.value; }
  friend bool operator!=(const Jet& a, const Jet& b) { return a.value != b.value; }

  /// f(this number), from f, f' and f'' at its value (S17).
  [[nodiscard]] Jet through(double f, double slope, double curvature) const {
    return {f, slope * gradient, slope * rate, slope * rate_of_rate + curvature * rate * rate};
  }
};

// The same names for plain numbers: without these a page's sin(0.3) would be a jet.
using std::abs, std::acos, std::asin, std::atan, std::atan2, std::cos, std::cosh, std::exp, std::hypot, std::log,
    std::pow, std::sin, std::sinh, std::sqrt, std::tan, std::tanh;

inline Jet sin(const Jet& x) {
  const double s = std::sin(x.value);
  return x.through(s, std::cos(x.value), -s);
}
inline Jet cos(const Jet& x) {
  const double c = std::cos(x.value);
  return x.through(c, -std::sin(x.value), -c);
}
inline Jet tan(const Jet& x) {
  const double t = std::tan(x.value);
  return x.through(t, 1.0 + t * t, 2.0 * t * (1.0 + t * t));
}
inline Jet asin(const Jet& x) {
  const double slope = 1.0 / std::sqrt(1.0 - x.value * x.value);
  return x.through(std::asin(x.value), slope, x.value * slope * slope * slope);
}
inline Jet acos(const Jet& x) { return Jet(std::acos(0.0)) - asin(x); }
inline Jet atan(const Jet& x) {
  const double slope = 1.0 / (1.0 + x.value * x.value);
  return x.through(std::atan(x.value), slope, -2.0 * x.value * slope * slope);
}
inline Jet sinh(const Jet& x) {
  const double s = std::sinh(x.value);
  return x.through(s, std::cosh(x.value), s);
}
inline Jet cosh(const Jet& x) {
  const double c = std::cosh(x.value);
  return x.through(c, std::sinh(x.value), c);
}
inline Jet tanh(const Jet& x) {
  const double t = std::tanh(x.value);
  return x.through(t, 1.0 - t * t, -2.0 * t * (1.0 - t * t));
}
inline Jet exp(const Jet& x) {
  const double e = std::exp(x.value);
  return x.through(e, e, e);
}
inline Jet log(const Jet& x) { return x.through(std::log(x.value), 1.0 / x.value, -1.0 / (x.value * x.value)); }
inline Jet sqrt(const Jet& x) {
  const double root = std::sqrt(x.value);
  return x.through(root, 0.5 / root, -0.25 / (root * x.value));
}
/// x^exponent for a constant exponent; x > 0, or an integer exponent of at least 2.
inline Jet pow(const Jet& x, double exponent) {
  return x.through(std::pow(x.value, exponent), exponent * std::pow(x.value, exponent - 1.0),
                   exponent * (exponent - 1.0) * std::pow(x.value, exponent - 2.0));
}
/// The nearest whole number, which has no derivatives.
inline double nearest_whole(double x) { return std::nearbyint(x); }
inline double nearest_whole(const Jet& x) { return std::nearbyint(x.value); }
inline Jet abs(const Jet& x) { return x.value < 0.0 ? -x : x; }
/// Away from the origin, like everything that has a derivative.
inline Jet hypot(const Jet& x, const Jet& y) { return sqrt(x * x + y * y); }
/// Angle of the point (x, y), away from the origin, in (-pi, pi]. Its derivatives are those of the angle by which the
/// point turns, without a cut: (x ydot - y xdot) / r^2.
inline Jet atan2(const Jet& y, const Jet& x) {
  const double square = x.value * x.value + y.value * y.value;
  const double turning = (x.value * y.rate - y.value * x.rate) / square;
  const double stretching = (x.value * x.rate + y.value * y.rate) / square;
  return {std::atan2(y.value, x.value), (x.value * y.gradient - y.value * x.gradient) / square, turning,
          (x.value * y.rate_of_rate - y.value * x.rate_of_rate) / square - 2.0 * turning * stretching};
}

}  // namespace concord::joints

/// Lets Eigen's matrices hold jets, and mix them with numbers.
namespace Eigen {

template <>
struct NumTraits<concord::joints::Jet> : NumTraits<double> {
  using Real = concord::joints::Jet;
  using NonInteger = concord::joints::Jet;
  using Nested = concord::joints::Jet;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 9,
    AddCost = 9,
    MulCost = 30
  };
};

template <class Operation>
struct ScalarBinaryOpTraits<concord::joints::Jet, double, Operation> {
  using ReturnType = concord::joints::Jet;
};

template <class Operation>
struct ScalarBinaryOpTraits<double, concord::joints::Jet, Operation> {
  using ReturnType = concord::joints::Jet;
};

}  // namespace Eigen
