#include "common/laws/time_function.h"

#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace concord {

namespace {

TimeFunctionValue evaluate_one(const ConstantSpeed& law, double t) {
  return {law.start + law.speed * t, law.speed, 0.0};
}

TimeFunctionValue evaluate_one(const Polynomial& law, double t) {
  TimeFunctionValue value;
  for (auto c = law.coefficients.rbegin(); c != law.coefficients.rend(); ++c) {
    value.fddot = value.fddot * t + 2.0 * value.fdot;
    value.fdot = value.fdot * t + value.f;
    value.f = value.f * t + *c;
  }
  return value;
}

TimeFunctionValue evaluate_one(const Harmonic& law, double t) {
  const double angle = law.frequency * t + law.phase;
  const double swing = law.amplitude * std::sin(angle);
  return {law.offset + swing, law.amplitude * law.frequency * std::cos(angle), -law.frequency * law.frequency * swing};
}

TimeFunctionValue evaluate_one(const SmoothStep& law, double t) {  // (S27)
  if (t <= law.t0) return {law.from, 0.0, 0.0};
  if (t >= law.t1) return {law.to, 0.0, 0.0};
  const double length = law.t1 - law.t0;
  const double s = (t - law.t0) / length;
  const double rise = law.to - law.from;
  const double s3 = s * s * s;
  const double value = s3 * s * (35.0 + s * (-84.0 + s * (70.0 - 20.0 * s)));
  const double slope = s3 * (140.0 + s * (-420.0 + s * (420.0 - 140.0 * s)));
  const double curvature = s * s * (420.0 + s * (-1680.0 + s * (2100.0 - 840.0 * s)));
  return {law.from + rise * value, rise * slope / length, rise * curvature / (length * length)};
}

TimeFunctionValue evaluate_one(const SplineTable& law, double t) { return law.evaluate(t); }

/// Second derivatives at the knots of the not-a-knot cubic spline: continuity of the slope at the inner knots, and of
/// the third derivative at the second and the last but one (S28).
std::vector<double> spline_curvatures(const std::vector<double>& t, const std::vector<double>& f) {
  const auto n = static_cast<Eigen::Index>(t.size());
  std::vector<Eigen::Triplet<double>> entries;
  VecX right = VecX::Zero(n);
  const auto width = [&](Eigen::Index k) { return t[k + 1] - t[k]; };
  for (Eigen::Index k = 1; k + 1 < n; ++k) {
    entries.emplace_back(k, k - 1, width(k - 1) / 6.0);
    entries.emplace_back(k, k, (width(k - 1) + width(k)) / 3.0);
    entries.emplace_back(k, k + 1, width(k) / 6.0);
    right(k) = (f[k + 1] - f[k]) / width(k) - (f[k] - f[k - 1]) / width(k - 1);
  }
  const auto same_third_derivative = [&](Eigen::Index row, Eigen::Index k) {
    // Times both widths: all rows are lengths then, so that the choice of pivots does not depend on the unit.
    entries.emplace_back(row, k - 1, width(k));
    entries.emplace_back(row, k, -width(k - 1) - width(k));
    entries.emplace_back(row, k + 1, width(k - 1));
  };
  same_third_derivative(0, 1);
  same_third_derivative(n - 1, n - 2);
  Eigen::SparseMatrix<double> equations(n, n);
  equations.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SparseLU<Eigen::SparseMatrix<double>> factors(equations);
  const VecX solution = factors.solve(right);
  return {solution.begin(), solution.end()};
}

}  // namespace

SplineTable::SplineTable(std::vector<double> times, std::vector<double> values)
    : times_(std::move(times)), values_(std::move(values)), curvatures_(spline_curvatures(times_, values_)) {}

TimeFunctionValue SplineTable::evaluate(double t) const { return evaluate(piece_at(t), t); }

int SplineTable::piece_at(double t) const {
  const auto above = std::upper_bound(times_.begin() + 1, times_.end() - 1, t);
  return static_cast<int>(above - times_.begin()) - 1;
}

TimeFunctionValue SplineTable::evaluate(int piece, double t) const {
  const auto k = static_cast<std::size_t>(piece);
  const double width = times_[k + 1] - times_[k];
  const double right = (t - times_[k]) / width;
  const double left = 1.0 - right;
  const double m0 = curvatures_[k];
  const double m1 = curvatures_[k + 1];
  const double w2 = width * width / 6.0;
  return {left * values_[k] + right * values_[k + 1] +
              w2 * ((left * left * left - left) * m0 + (right * right * right - right) * m1),
          (values_[k + 1] - values_[k]) / width +
              width / 6.0 * ((1.0 - 3.0 * left * left) * m0 + (3.0 * right * right - 1.0) * m1),
          left * m0 + right * m1};
}

TimeFunctionValue evaluate(const TimeFunction& function, double t) {
  return std::visit([t](const auto& law) { return evaluate_one(law, t); }, function);
}

}  // namespace concord
