#include "compare/audit/law_of_time.h"

#include <algorithm>
#include <cmath>

namespace concord::compare {

namespace {

using Real = long double;

/// Slopes at the points of a not-a-knot spline: the second derivative is continuous at the inner points, the third at
/// the second and the last but one. Tridiagonal, solved from the first row to the last and back, with digits to spare
/// for a short piece between long ones.
std::vector<Real> spline_slopes(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  const auto width = [&](std::size_t k) { return Real(x[k + 1]) - x[k]; };
  const auto chord = [&](std::size_t k) { return (Real(y[k + 1]) - y[k]) / width(k); };
  // The right side of an end's row, from the widths and chords of its own piece and of the next one.
  const auto end_right = [](Real near, Real far, Real near_chord, Real far_chord) {
    return ((3 * near + 2 * far) * far * near_chord + near * near * far_chord) / (near + far);
  };
  std::vector<Real> above(n);  // what is left of the next slope in each row once its own factor is one
  std::vector<Real> slopes(n);
  above[0] = (width(0) + width(1)) / width(1);
  slopes[0] = end_right(width(0), width(1), chord(0), chord(1)) / width(1);
  for (std::size_t k = 1; k + 1 < n; ++k) {
    const Real before = width(k - 1);
    const Real after = width(k);
    const Real own = 2 * (before + after) - after * above[k - 1];
    above[k] = before / own;
    slopes[k] = (3 * (after * chord(k - 1) + before * chord(k)) - after * slopes[k - 1]) / own;
  }
  const Real near = width(n - 2);
  const Real far = width(n - 3);
  slopes[n - 1] = (end_right(near, far, chord(n - 2), chord(n - 3)) - (near + far) * slopes[n - 2]) /
                  (far - (near + far) * above[n - 2]);
  for (std::size_t k = n - 1; k-- > 0;) slopes[k] -= above[k] * slopes[k + 1];
  return slopes;
}

}  // namespace

Moving sine(const Moving& angle) {
  const double s = std::sin(angle.value);
  const double c = std::cos(angle.value);
  return {s, c * angle.rate, c * angle.rate_of_rate - s * angle.rate * angle.rate};
}

Spline::Spline(const std::vector<double>& x, const std::vector<double>& y) : x_(x), y_(y) {
  const std::vector<Real> slopes = spline_slopes(x, y);
  for (std::size_t k = 0; k + 1 < x.size(); ++k) {
    const Real width = Real(x[k + 1]) - x[k];
    const Real chord = (Real(y[k + 1]) - y[k]) / width;
    const Real twist = (slopes[k] + slopes[k + 1] - 2 * chord) / (width * width);
    const auto powers_from = [&](std::size_t near, std::size_t far, int forward) {
      const Real bend = forward * (3 * chord - 2 * slopes[near] - slopes[far]) / width;
      return Powers{static_cast<double>(slopes[near]), static_cast<double>(bend), static_cast<double>(twist)};
    };
    pieces_.push_back({powers_from(k, k + 1, 1), powers_from(k + 1, k, -1)});
  }
}

/// Of the piece between two points, by how far x is from the nearer one: the polynomial with the two values
/// and slopes.
Moving Spline::at(const Moving& x) const {
  const auto inner_points_below = std::upper_bound(x_.begin() + 1, x_.end() - 1, x.value) - (x_.begin() + 1);
  const auto k = static_cast<std::size_t>(inner_points_below);
  const bool from_left = x.value - x_[k] <= x_[k + 1] - x.value;
  const Powers& powers = pieces_[k][from_left ? 0 : 1];
  const std::size_t near = from_left ? k : k + 1;
  const Moving along = -x_[near] + x;
  return y_[near] + along * (powers.slope + along * (powers.bend + powers.twist * along));
}

LawOfTime::LawOfTime(const TimeFunction& stated) : stated_(&stated) {
  if (const auto* table = std::get_if<SplineTable>(&stated)) curve_.emplace(*table);
}

Moving LawOfTime::at(double t) const {
  return std::visit([&](const auto& law) { return evaluate(law, at_unit_rate(t)); }, *stated_);
}

Moving LawOfTime::evaluate(const ConstantSpeed& law, const Moving& t) const { return law.start + law.speed * t; }

Moving LawOfTime::evaluate(const Polynomial& law, const Moving& t) const {
  Moving sum;
  Moving power{1.0, 0.0, 0.0};
  for (const double coefficient : law.coefficients) {
    sum = sum + coefficient * power;
    power = power * t;
  }
  return sum;
}

Moving LawOfTime::evaluate(const Harmonic& law, const Moving& t) const {
  return law.offset + law.amplitude * sine(law.phase + law.frequency * t);
}

/// s^4 (1 + 4 z + 10 z^2 + 20 z^3) with z = 1 - s is the polynomial of degree 7 from 0 to 1 whose first three
/// derivatives vanish at both ends.
Moving LawOfTime::evaluate(const SmoothStep& law, const Moving& t) const {
  if (t.value <= law.t0) return {law.from, 0.0, 0.0};
  if (t.value >= law.t1) return {law.to, 0.0, 0.0};
  const Moving s = 1.0 / (law.t1 - law.t0) * (-law.t0 + t);
  const Moving z = 1.0 / (law.t1 - law.t0) * (law.t1 + -1.0 * t);
  const Moving square = s * s;
  const Moving share = square * square * (1.0 + z * (4.0 + z * (10.0 + 20.0 * z)));
  return law.from + (law.to - law.from) * share;
}

Moving LawOfTime::evaluate(const SplineTable& /*law*/, const Moving& t) const { return curve_->at(t); }

}  // namespace concord::compare
