#include "compare/quantities/curve_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace concord::compare {
namespace {

/// Whole periods of a sine, evenly sampled, and another curve beside it.
template <class Curve>
CurveMetrics beside_a_sine(const Curve& curve) {
  std::vector<double> times;
  std::array<std::vector<double>, 2> curves;
  for (int k = 0; k < 400; ++k) {
    const double t = k * 4.0 * std::numbers::pi / 400;
    times.push_back(t);
    curves[0].push_back(3.0 * std::sin(t));
    curves[1].push_back(curve(t));
  }
  return compare_curves(times, curves);
}

TEST(CurveMetricsTest, EqualCurvesDifferByNothing) {
  const CurveMetrics same = beside_a_sine([](double t) { return 3.0 * std::sin(t); });
  EXPECT_DOUBLE_EQ(same.rms_over_range, 0.0);
  EXPECT_NEAR(same.magnitude, 0.0, 1e-15);
  EXPECT_NEAR(same.phase, 0.0, 1e-7);  // an arc cosine near 1 resolves half of the digits
  EXPECT_DOUBLE_EQ(same.peak[0], 3.0);
  EXPECT_NEAR(same.t_peak[0], std::numbers::pi / 2.0, 1e-12);
}

TEST(CurveMetricsTest, ALargerCurveDiffersInMagnitudeAlone) {
  const CurveMetrics larger = beside_a_sine([](double t) { return 3.6 * std::sin(t); });
  EXPECT_NEAR(larger.magnitude, 0.2, 1e-14);
  EXPECT_NEAR(larger.phase, 0.0, 1e-7);
  EXPECT_NEAR(larger.combined, 0.2, 1e-14);
  EXPECT_NEAR(larger.rms_over_range, 0.6 / std::sqrt(2.0) / 6.0, 1e-14);
}

TEST(CurveMetricsTest, AShiftedCurveDiffersInPhaseAlone) {
  const CurveMetrics shifted = beside_a_sine([](double t) { return 3.0 * std::sin(t - 0.3); });
  EXPECT_NEAR(shifted.magnitude, 0.0, 1e-14);
  EXPECT_NEAR(shifted.phase, 0.3 / std::numbers::pi, 1e-14);
  EXPECT_NEAR(shifted.t_peak[1] - shifted.t_peak[0], 0.3, 0.03);
}

TEST(CurveMetricsTest, ZerosHaveNoMagnitudeAndNoPhase) {
  const CurveMetrics zero = beside_a_sine([](double) { return 0.0; });
  EXPECT_DOUBLE_EQ(zero.magnitude, 0.0);
  EXPECT_DOUBLE_EQ(zero.phase, 0.0);
  EXPECT_GT(zero.rms_over_range, 0.3);
  EXPECT_DOUBLE_EQ(compare_curves({}, {}).combined, 0.0);
  EXPECT_DOUBLE_EQ(compare_curves({0.0, 1.0}, {{{10.0, 10.0}, {12.0, 12.0}}}).rms_over_range, 2.0 / 12.0);  // at rest
}

}  // namespace
}  // namespace concord::compare
