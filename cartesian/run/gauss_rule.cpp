#include "cartesian/run/gauss_rule.h"

#include <cmath>

namespace concord::cartesian {

namespace {

/// P_0 to P_kPoints at x in [-1, 1].
std::array<double, kPoints + 1> legendre_polynomials(double x) {
  std::array<double, kPoints + 1> P{1.0, x};
  for (int k = 1; k < kPoints; ++k) P[k + 1] = ((2 * k + 1) * x * P[k] - k * P[k - 1]) / (k + 1);
  return P;
}

/// The zeros of P_n by Newton's method, from Tricomi's guesses.
GaussRule make_rule() {
  constexpr int kIterations = 8;
  constexpr int n = kPoints;
  GaussRule rule{};
  for (int i = 0; i < n; ++i) {
    double x = -std::cos(M_PI * (i + 0.75) / (n + 0.5));
    double slope = 0.0;
    for (int k = 0; k < kIterations; ++k) {
      const auto P = legendre_polynomials(x);
      slope = n * (x * P[n] - P[n - 1]) / (x * x - 1.0);
      x -= P[n] / slope;
    }
    rule.points[i] = 0.5 * (1.0 + x);
    rule.weights[i] = 1.0 / ((1.0 - x * x) * slope * slope);
  }
  return rule;
}

PointSquare make_legendre_coefficients() {
  const GaussRule& rule = gauss_rule();
  PointSquare factors;
  for (int i = 0; i < kPoints; ++i) {
    const auto P = legendre_polynomials(2.0 * rule.points[i] - 1.0);
    for (int k = 0; k < kPoints; ++k) factors(k, i) = (2 * k + 1) * rule.weights[i] * P[k];
  }
  return factors;
}

}  // namespace

const GaussRule& gauss_rule() {
  static const GaussRule rule = make_rule();
  return rule;
}

void write_interpolation(const double* nodes, int count, double x, double* factors) {
  for (int j = 0; j < count; ++j) {
    factors[j] = 1.0;
    for (int i = 0; i < count; ++i) {
      if (i != j) factors[j] *= (x - nodes[i]) / (nodes[j] - nodes[i]);
    }
  }
}

PointRow integral_to(double x) {
  const GaussRule& rule = gauss_rule();
  PointRow sum = PointRow::Zero();
  PointRow factors;
  for (int i = 0; i < kPoints; ++i) {
    write_interpolation(rule.points.data(), kPoints, x * rule.points[i], factors.data());
    sum += x * rule.weights[i] * factors;
  }
  return sum;
}

const PointSquare& legendre_coefficients() {
  static const PointSquare factors = make_legendre_coefficients();
  return factors;
}

}  // namespace concord::cartesian
