#include "common/evaluation_limit.h"

#include <gtest/gtest.h>

#include "common/error.h"

namespace concord {
namespace {

EvaluationLimit explicit_run(double until, std::optional<long> most = {}, bool foresees_end = false) {
  return EvaluationLimit(
      {.solver = "cartesian", .integrator = "gauss", .until = until, .most = most, .foresees_end = foresees_end});
}

EvaluationLimit implicit_run(double until) {
  return EvaluationLimit({.solver = "relative", .integrator = "dirk", .until = until, .cost = 3.0});
}

/// Steps of `step` [s] with `each` evaluations up to `until`; the time at which the limit refuses to go on, or `until`.
double goes_to(EvaluationLimit& limit, double until, double step, long each, long already = 0) {
  long evaluations = already;
  for (double t = step; t < until; t += step) {
    evaluations += each;
    try {
      limit.require(t, evaluations);
    } catch (const TooManyEvaluations&) {
      return t;
    }
  }
  return until;
}

TEST(EvaluationLimit, LetsARunGoOnThatIsNotTooHard) {
  EvaluationLimit limit = explicit_run(4.0);
  EXPECT_EQ(goes_to(limit, 4.0, 1e-4, 150), 4.0);  // 6 million in all
}

TEST(EvaluationLimit, RefusesARunThatIsHardThroughout) {
  EvaluationLimit limit = explicit_run(4.0);
  EXPECT_LT(goes_to(limit, 4.0, 1e-4, 3000), 0.1);  // 120 million in all, a hundredth of it was seen
  EvaluationLimit less = explicit_run(4.0);
  EXPECT_LT(goes_to(less, 4.0, 1e-4, 800), 0.5);  // 32 million: a tenth
}

TEST(EvaluationLimit, AllowsLessWhereEvaluationsCostMore) {
  EvaluationLimit limit = implicit_run(4.0);
  EXPECT_EQ(goes_to(limit, 4.0, 1e-4, 50), 4.0);  // 2 million in all
  EvaluationLimit implicit = implicit_run(4.0);
  EXPECT_LT(goes_to(implicit, 4.0, 1e-4, 300), 0.5);  // 12 million: a tenth
}

TEST(EvaluationLimit, HoldsTheWholeRunToWhatItWasGiven) {
  EvaluationLimit limit = explicit_run(4.0, 100'000);
  EXPECT_LT(goes_to(limit, 4.0, 1e-3, 50), 2.01);  // 200000 in all
  EvaluationLimit enough = explicit_run(4.0, 300'000);
  EXPECT_EQ(goes_to(enough, 4.0, 1e-3, 50), 4.0);
}

TEST(EvaluationLimit, ForeseesWhatIsNotEnoughAfterATenthOfIt) {
  EvaluationLimit limit = explicit_run(4.0, 100'000, true);
  EXPECT_LT(goes_to(limit, 4.0, 1e-3, 60), 0.2);  // 240000 in all
  EvaluationLimit early = explicit_run(4.0, 100'000, true);
  EXPECT_NO_THROW(early.require(0.05, 9'900));  // too early to tell
  EXPECT_THROW(early.require(0.1, 10'100), EvaluationsSpent);
  EvaluationLimit nearly = explicit_run(4.0, 100'000, true);
  EXPECT_GT(goes_to(nearly, 4.0, 1e-3, 40), 2.4);  // 160000 in all: it may become easier
}

TEST(EvaluationLimit, LetsAShortHardPhasePass) {
  EvaluationLimit limit = explicit_run(4.0);
  EXPECT_EQ(goes_to(limit, 0.003, 1e-6, 80), 0.003);  // 240000 within a thousandth
  EXPECT_EQ(goes_to(limit, 4.0, 1e-3, 200, 240'000), 4.0);
}

TEST(EvaluationLimit, SaysWhereAndOfWhichIntegrator) {
  EvaluationLimit limit = explicit_run(0.5);
  try {
    for (long n = 1; n < 10; ++n) limit.require(1e-6 * double(n), 100'000 * n, [] { return "; at the elbow"; });
    FAIL() << "900000 evaluations for 9e-6 s";
  } catch (const TooManyEvaluations& error) {
    EXPECT_STREQ(error.what(),
                 "cartesian: at t = 4e-06 s 300000 evaluations advanced the run by 4.0e-06 s only: the run is long "
                 "beside the motion, or the motion locks "
                 "there, or is too stiff for gauss; at the elbow");
  }
}

}  // namespace
}  // namespace concord
