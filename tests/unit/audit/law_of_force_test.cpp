#include "compare/audit/law_of_force.h"

#include <gtest/gtest.h>

#include <cmath>

namespace concord::compare {
namespace {

/// A stop by its statement: the stiffness grows over the width as z^2 (3 - 2 z), summed by the midpoint rule.
double summed_stop(const SmoothStop& stop, double p, double pdot) {
  constexpr int kPieces = 20000;
  double spring = 0.0;
  const auto share = [&](double at) {
    const double z = std::min(at / stop.width, 1.0);
    return z * z * (3.0 - 2.0 * z);
  };
  for (int k = 0; k < kPieces; ++k) spring += stop.stiffness * share(p * (k + 0.5) / kPieces) * p / kPieces;
  return std::max(0.0, spring + stop.damping * share(p) * pdot);
}

TEST(LawOfForce, AddsPreloadLinesTablesAndStops) {
  ForceLaw stated;
  stated.stiffness = 150.0;
  stated.damping = 4.0;
  stated.free = 0.31;
  stated.preload = -6.0;
  stated.spring_table = ForceTable({-0.2, 0.0, 0.1, 0.3}, {-5.0, 0.0, 4.0, 30.0});
  stated.damper_table = ForceTable({-1.0, -0.3, 0.2, 0.9}, {-2.0, -1.0, 0.4, 3.0});
  stated.upper = SmoothStop{.at = 0.6, .stiffness = 800.0, .damping = 9.0, .width = 0.04};
  stated.lower = SmoothStop{.at = 0.1, .stiffness = 500.0, .damping = 7.0, .width = 0.06};
  stated.actuator = Harmonic{0.5, 2.0, 3.0, 0.1};
  const LawOfForce law(stated);
  // At points of both tables: 0.41 - free = 0.1, and x' = 0.2.
  EXPECT_NEAR(law.resistance(0.41, 0.2), -6.0 + 15.0 + 0.8 + 4.0 + 0.4, 1e-12);
  EXPECT_NEAR(law.actuator(0.7), 0.5 + 2.0 * std::sin(2.2), 1e-14);
  for (const double p : {0.01, 0.035, 0.09}) {
    ForceLaw without = stated;
    without.upper.reset();
    without.lower.reset();
    const LawOfForce rest(without);
    EXPECT_NEAR(law.resistance(0.6 + p, 0.5) - rest.resistance(0.6 + p, 0.5), summed_stop(*stated.upper, p, 0.5), 1e-7);
    EXPECT_NEAR(law.resistance(0.1 - p, -0.5) - rest.resistance(0.1 - p, -0.5), -summed_stop(*stated.lower, p, 0.5),
                1e-7);
  }
}

TEST(LawOfForce, TablesGoOnStraight) {
  ForceLaw stated;
  stated.spring_table = ForceTable({-0.2, 0.0, 0.1, 0.3}, {-5.0, 0.0, 4.0, 30.0});
  const LawOfForce law(stated);
  for (const double end : {-0.2, 0.3}) {
    const double way = end > 0.0 ? 1.0 : -1.0;
    const double slope = (law.resistance(end, 0.0) - law.resistance(end - way * 1e-6, 0.0)) / (way * 1e-6);
    EXPECT_NEAR(law.resistance(end + way * 2.0, 0.0), law.resistance(end, 0.0) + way * 2.0 * slope, 1e-2);
    EXPECT_NEAR(law.resistance(end + way * 2.0, 0.0) - law.resistance(end + way * 1.0, 0.0),
                law.resistance(end + way * 1.0, 0.0) - law.resistance(end, 0.0), 1e-12);
  }
}

TEST(LawOfForce, SaysWhatTheSolversEvaluatorSays) {
  ForceLaw stated;
  stated.stiffness = 90.0;
  stated.free = -0.2;
  stated.spring_table = ForceTable({-0.4, -0.1, 0.1, 0.2, 0.6}, {-9.0, -2.0, 1.0, 1.5, 22.0});
  stated.damper_table = ForceTable({-1.0, -0.3, 0.2, 0.9}, {-2.0, -1.0, 0.4, 3.0});
  stated.upper = SmoothStop{.at = 0.3, .stiffness = 700.0, .damping = 21.0, .width = 0.05};
  stated.lower = SmoothStop{.at = -0.5, .stiffness = 600.0, .damping = 17.0, .width = 0.03};
  const LawOfForce law(stated);
  for (double x = -0.8; x < 0.7; x += 0.0137) {
    for (const double xdot : {-6.0, -0.8, 0.0, 0.1, 2.5}) {
      const double other = evaluate_resistance(stated, x, xdot).force;
      EXPECT_NEAR(law.resistance(x, xdot), other, 1e-13 * (100.0 + std::abs(other))) << x << ", " << xdot;
    }
  }
}

TEST(LawOfForce, AStopThatIsLeftFastDoesNotPull) {
  ForceLaw stated;
  stated.upper = SmoothStop{.at = 0.2, .stiffness = 400.0, .damping = 30.0, .width = 0.02};
  stated.lower = SmoothStop{.at = -0.1, .stiffness = 300.0, .damping = 40.0, .width = 0.05};
  const LawOfForce law(stated);
  EXPECT_EQ(law.resistance(0.21, -3.0), 0.0);
  EXPECT_EQ(law.resistance(-0.12, 3.0), 0.0);
  EXPECT_GT(law.resistance(0.21, 3.0), 0.0);
  EXPECT_LT(law.resistance(-0.12, -3.0), 0.0);
}

}  // namespace
}  // namespace concord::compare
