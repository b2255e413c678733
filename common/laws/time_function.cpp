#include "common/laws/time_function.h"

#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <limits>
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

/// A short piece between long ones is determined by small differences of the widths' sums, which double rounds away.
using Extended = long double;
using ExtendedVector = Eigen::Matrix<Extended, Eigen::Dynamic, 1>;

/// Second derivatives at the knots of the not-a-knot cubic spline: continuity of the slope at the inner knots, and of
/// the third derivative at the second and the last but one (S28). Not a number where they are not resolved.
ExtendedVector spline_curvatures(const std::vector<double>& t, const std::vector<double>& f) {
  const auto n = static_cast<Eigen::Index>(t.size());
  std::vector<Eigen::Triplet<Extended>> entries;
  ExtendedVector right = ExtendedVector::Zero(n);
  const auto width = [&](Eigen::Index k) { return static_cast<Extended>(t[k + 1]) - t[k]; };
  for (Eigen::Index k = 1; k + 1 < n; ++k) {
    entries.emplace_back(k, k - 1, width(k - 1) / 6);
    entries.emplace_back(k, k, (width(k - 1) + width(k)) / 3);
    entries.emplace_back(k, k + 1, width(k) / 6);
    right(k) =
        (static_cast<Extended>(f[k + 1]) - f[k]) / width(k) - (static_cast<Extended>(f[k]) - f[k - 1]) / width(k - 1);
  }
  const auto same_third_derivative = [&](Eigen::Index row, Eigen::Index k) {
    // Times both widths: all rows are lengths then, so that the choice of pivots does not depend on the unit.
    entries.emplace_back(row, k - 1, width(k));
    entries.emplace_back(row, k, -width(k - 1) - width(k));
    entries.emplace_back(row, k + 1, width(k - 1));
  };
  same_third_derivative(0, 1);
  same_third_derivative(n - 1, n - 2);
  Eigen::SparseMatrix<Extended> equations(n, n);
  equations.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SparseLU<Eigen::SparseMatrix<Extended>> factors(equations);
  if (factors.info() != Eigen::Success) {
    return ExtendedVector::Constant(n, std::numeric_limits<Extended>::quiet_NaN());
  }
  return factors.solve(right);
}

/// Slopes at the knots, each from the shorter piece beside it.
std::vector<double> spline_slopes(const std::vector<double>& t, const std::vector<double>& f,
                                  const ExtendedVector& curvatures) {
  const std::size_t n = t.size();
  std::vector<double> slopes(n);
  for (std::size_t k = 0; k < n; ++k) {
    const bool is_before = k + 1 == n || (k > 0 && t[k] - t[k - 1] < t[k + 1] - t[k]);
    const std::size_t other = is_before ? k - 1 : k + 1;
    const Extended way = static_cast<Extended>(t[other]) - t[k];
    const auto knot = static_cast<Eigen::Index>(k);
    const auto next = static_cast<Eigen::Index>(other);
    slopes[k] = static_cast<double>((static_cast<Extended>(f[other]) - f[k]) / way -
                                    way / 6 * (2 * curvatures(knot) + curvatures(next)));
  }
  return slopes;
}

}  // namespace

SplineTable::SplineTable(std::vector<double> times, std::vector<double> values)
    : times_(std::move(times)), values_(std::move(values)) {
  const ExtendedVector curvatures = spline_curvatures(times_, values_);
  slopes_ = spline_slopes(times_, values_, curvatures);
  for (const Extended curvature : curvatures) curvatures_.push_back(static_cast<double>(curvature));
}

TimeFunctionValue SplineTable::evaluate(double t) const { return evaluate(piece_at(t), t); }

int SplineTable::piece_at(double t) const {
  const auto above = std::upper_bound(times_.begin() + 1, times_.end() - 1, t);
  return static_cast<int>(above - times_.begin()) - 1;
}

/// By powers of the way from the nearer knot, so that a long piece is exact beside a short one.
TimeFunctionValue SplineTable::evaluate(int piece, double t) const {
  const auto k = static_cast<std::size_t>(piece);
  const std::size_t nearer = t - times_[k] <= times_[k + 1] - t ? k : k + 1;
  const double s = t - times_[nearer];
  const double third = (curvatures_[k + 1] - curvatures_[k]) / (times_[k + 1] - times_[k]);
  const double m = curvatures_[nearer];
  const double slope = slopes_[nearer];
  return {values_[nearer] + s * (slope + s * (m / 2.0 + s * third / 6.0)), slope + s * (m + s * third / 2.0),
          m + s * third};
}

TimeFunctionValue evaluate(const TimeFunction& function, double t) {
  return std::visit([t](const auto& law) { return evaluate_one(law, t); }, function);
}

}  // namespace concord
