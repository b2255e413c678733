#include "common/line_watch.h"

#include <gtest/gtest.h>

#include "common/error.h"
#include "common/rotation.h"

namespace concord {
namespace {

constexpr double kLength = 2.0;  // of the machine, m
const std::string kName = "cord";

/// Where two ends stand that move steadily, `offset` beside each other when they are nearest, at t = 0.
SpringLine steady(double t, double offset, bool jumps = true) {
  const Mat3 tilted = rotation_about(Vec3(1.0, -2.0, 0.5).normalized(), 0.7);
  return {&kName, tilted * Vec3(0.3 * t, offset, 0.0), tilted * Vec3(0.3, 0.0, 0.0), jumps};
}

std::string stop_of(const std::vector<std::pair<double, SpringLine>>& steps) {
  LineWatch watch("relative", kLength);
  try {
    for (const auto& [t, line] : steps) watch.pass(t, {line});
    watch.settle();
  } catch (const SolverError& error) {
    return error.what();
  }
  return "";
}

TEST(LineWatch, SeesEndsPassEachOther) {
  EXPECT_EQ(stop_of({{-0.2, steady(-0.2, 1e-9)}, {-0.1, steady(-0.1, 1e-9)}, {0.05, steady(0.05, 1e-9)}}),
            "relative: at t = 0.05 s the ends of line spring 'cord' have met since t = -0.1 s: its force has no "
            "direction there");
  EXPECT_EQ(stop_of({{-0.2, steady(-0.2, 0.0)}, {-0.1, steady(-0.1, 0.0)}}), "");  // not there yet
  EXPECT_EQ(stop_of({{0.1, steady(0.1, 0.0)}, {0.2, steady(0.2, 0.0)}}), "");      // gone apart
  EXPECT_EQ(stop_of({{-0.1, steady(-0.1, 0.3)}, {0.1, steady(0.1, 0.3)}}), "");    // passes at a distance
  EXPECT_EQ(stop_of({{-0.1, steady(-0.1, 0.0, false)}, {0.1, steady(0.1, 0.0, false)}}), "");
}

/// x = rest + t^2 / 2: turns round at t = 0.
SpringLine turning_round(double t, double rest) {
  const Vec3 along = Vec3(2.0, 1.0, -3.0).normalized();
  return {&kName, (rest + 0.5 * t * t) * along, t * along, true};
}

TEST(LineWatch, SeesEndsTouch) {
  EXPECT_NE(stop_of({{-0.1, turning_round(-0.1, 0.0)}, {0.15, turning_round(0.15, 0.0)}}), "");
  EXPECT_NE(stop_of({{-0.1, turning_round(-0.1, 1e-7)}, {0.15, turning_round(0.15, 1e-7)}}), "");
  EXPECT_EQ(stop_of({{-0.1, turning_round(-0.1, 1e-4)}, {0.15, turning_round(0.15, 1e-4)}}), "");
}

/// A line of constant length that turns about an axis across it.
TEST(LineWatch, LetsALineTurnFast) {
  const auto turning = [](double t) {
    const Mat3 A = rotation_about(Vec3::UnitZ(), 40.0 * t);
    return SpringLine{&kName, A * Vec3(0.2, 0.0, 0.1), A * Vec3(0.0, 8.0, 0.0), true};
  };
  EXPECT_EQ(stop_of({{0.0, turning(0.0)}, {0.08, turning(0.08)}, {0.16, turning(0.16)}}), "");
}

TEST(LineWatch, ForgetsStepsThatAreMadeAnew) {
  EXPECT_EQ(stop_of({{-0.2, steady(-0.2, 0.0)}, {0.1, steady(0.1, 0.0)}, {-0.1, steady(-0.1, 0.0)}}), "");
  EXPECT_NE(stop_of({{-0.2, steady(-0.2, 0.0)}, {0.1, steady(0.1, 0.0)}, {0.1, steady(0.1, 0.0)}}), "");
}

}  // namespace
}  // namespace concord
