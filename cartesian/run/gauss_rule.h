#pragma once

#include <array>

#include "common/types.h"

/// Gauss's points in a step, and the polynomial through values there.
namespace concord::cartesian {

/// Points in one step of the collocation method.
inline constexpr int kPoints = 8;
/// One number for each of them.
using PointRow = Eigen::Matrix<double, 1, kPoints>;
using PointSquare = Eigen::Matrix<double, kPoints, kPoints>;

/// Gauss's rule on [0, 1].
struct GaussRule {
  std::array<double, kPoints> points;   // rising
  std::array<double, kPoints> weights;  // their sum is 1
};
const GaussRule& gauss_rule();

/// The factors of values at `count` different nodes in the polynomial through them, at x (Lagrange).
void write_interpolation(const double* nodes, int count, double x, double* factors);

/// The factors of values at the points in the integral from 0 to x of the polynomial through them.
PointRow integral_to(double x);

/// Row k: the factors of values at the points in the k-th Legendre coefficient, on [0, 1], of the polynomial through
/// them.
const PointSquare& legendre_coefficients();

}  // namespace concord::cartesian
