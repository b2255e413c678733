#include "compare/resolution/horizon.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

/// Growth by a factor of e in `e_fold` seconds, at times 0, 0.1, ...
Growth exponential(double e_fold, int samples = 101) {
  Growth growth;
  for (int k = 0; k < samples; ++k) {
    growth.times.push_back(0.1 * k);
    growth.factors.push_back(std::exp(0.1 * k / e_fold));
  }
  return growth;
}

TEST(Horizon, ARunAllowsWhatItsToleranceLeavesAboveTheNeed) {
  EXPECT_NEAR(allowed_growth(1e-13, 7.0), 1e4, 1.0);
  EXPECT_NEAR(allowed_growth(1e-13, 5.0), 1e6, 100.0);
  EXPECT_GE(allowed_growth(1e-9, 8.5), 10.0);  // and never less than is seen to grow
}

TEST(Horizon, IsTheLastSampleBeforeNeighboursHavePartedTooFar) {
  const Growth growth = exponential(1.0);
  EXPECT_EQ(growth.samples_within(std::exp(2.05)), 21);
  EXPECT_EQ(growth.samples_within(1e9), 101);
}

TEST(Horizon, IsTheShorterOfTwoThatAgree) {
  const auto horizon = find_horizon({exponential(1.0), exponential(0.9)}, std::exp(5.05));
  ASSERT_TRUE(horizon);
  EXPECT_TRUE(horizon->agree);
  EXPECT_EQ(horizon->samples, 46);
  EXPECT_DOUBLE_EQ(horizon->times[0], 5.0);
  EXPECT_DOUBLE_EQ(horizon->times[1], 4.5);
}

TEST(Horizon, TwoThatAreFarApartDoNotAgree) {
  const auto horizon = find_horizon({exponential(1.0), exponential(0.5)}, std::exp(5.05));
  ASSERT_TRUE(horizon);
  EXPECT_FALSE(horizon->agree);
}

TEST(Horizon, ThereIsNoneWhereEitherMotionStaysTogether) {
  EXPECT_FALSE(find_horizon({exponential(1.0), exponential(1e3)}, std::exp(5.05)));
  EXPECT_FALSE(find_horizon({exponential(1e3), exponential(1e3)}, std::exp(5.05)));
}

TEST(Horizon, ASolverThatDoesNotStartBesideItsRunSaysNothing) {
  const Model model = pendulum_model();
  FakePendulum solver(model, "cartesian");  // knows no start but the model's
  RunOptions options;
  options.samples = 4;
  EXPECT_FALSE(measure_growth(model, solver, options, solver.integrate(options, {}), 1e-6, 1));
}

TEST(Horizon, ASolverThatDoesNotFinishSaysNothing) {
  const Model model = pendulum_model();
  FakePendulum solver(model, "cartesian");
  RunOptions options;
  options.samples = 4;
  const Trajectory run = solver.integrate(options, {});
  solver.cannot_integrate = true;
  EXPECT_FALSE(measure_growth(model, solver, options, run, 1e-6, 1));
}

}  // namespace
}  // namespace concord::compare
