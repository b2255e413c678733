#include "common/laws/time_function.h"

#include <gtest/gtest.h>

#include <cmath>

namespace concord {
namespace {

const std::vector<double> kTimes{0.0, 0.31, 0.55, 1.2, 1.41, 2.0};

double cubic(double t) { return 0.3 - 1.1 * t + 0.7 * t * t - 0.4 * t * t * t; }

SplineTable table_of(double (*f)(double)) {
  std::vector<double> values;
  for (const double t : kTimes) values.push_back(f(t));
  return {kTimes, values};
}

struct NamedFunction {
  const char* name;
  TimeFunction function;
};

std::vector<NamedFunction> one_of_each_kind() {
  return {{"constant speed", ConstantSpeed{0.3, 150.0}},
          {"polynomial", Polynomial{{0.2, -1.0, 0.5, 2.0, -0.7}}},
          {"harmonic", Harmonic{0.1, 0.8, 7.3, 0.4}},
          {"smooth step", SmoothStep{0.2, 1.7, -0.5, 1.3}},
          {"spline", table_of([](double t) { return std::sin(3.0 * t); })}};
}

TEST(TimeFunction, DerivativesAgreeWithDifferences) {
  const double step = 1e-4;
  for (const NamedFunction& one : one_of_each_kind()) {
    for (const double t : {-0.13, 0.11, 0.37, 0.83, 1.05, 1.63, 2.2}) {
      const TimeFunctionValue here = evaluate(one.function, t);
      const TimeFunctionValue before = evaluate(one.function, t - step);
      const TimeFunctionValue after = evaluate(one.function, t + step);
      EXPECT_NEAR((after.f - before.f) / (2.0 * step), here.fdot, 2e-6) << one.name << " at " << t;
      EXPECT_NEAR((after.fdot - before.fdot) / (2.0 * step), here.fddot, 2e-5) << one.name << " at " << t;
    }
  }
}

TEST(TimeFunction, ValuesAtKnownTimes) {
  EXPECT_DOUBLE_EQ(evaluate(ConstantSpeed{0.3, 150.0}, 2.0).f, 300.3);
  EXPECT_DOUBLE_EQ(evaluate(Polynomial{{1.0, 2.0, 3.0}}, 2.0).f, 17.0);
  EXPECT_DOUBLE_EQ(evaluate(Polynomial{{1.0, 2.0, 3.0}}, 2.0).fddot, 6.0);
  EXPECT_DOUBLE_EQ(evaluate(Polynomial{{}}, 2.0).f, 0.0);
  EXPECT_DOUBLE_EQ(evaluate(Harmonic{0.1, 0.8, 7.3, 0.4}, 0.5).f, 0.1 + 0.8 * std::sin(7.3 * 0.5 + 0.4));
}

TEST(TimeFunction, SmoothStepRestsOutsideAndIsSmoothAtItsEnds) {
  const SmoothStep step{0.2, 1.7, -0.5, 1.3};
  EXPECT_EQ(evaluate(step, 0.1).f, -0.5);
  EXPECT_EQ(evaluate(step, 2.0).f, 1.3);
  EXPECT_DOUBLE_EQ(evaluate(step, 0.95).f, 0.4);
  for (const double inside : {0.2 + 1e-6, 1.7 - 1e-6}) {
    EXPECT_NEAR(evaluate(step, inside).fdot, 0.0, 1e-12);
    EXPECT_NEAR(evaluate(step, inside).fddot, 0.0, 1e-9);
  }
}

TEST(TimeFunction, NotAKnotSplineReproducesACubicInsideAndOutsideTheTable) {
  const SplineTable table = table_of(cubic);
  for (const double t : {-0.4, 0.0, 0.1, 0.31, 0.9, 1.3, 1.7, 2.0, 2.6}) {
    const TimeFunctionValue value = table.evaluate(t);
    EXPECT_NEAR(value.f, cubic(t), 1e-13) << t;
    EXPECT_NEAR(value.fdot, -1.1 + 1.4 * t - 1.2 * t * t, 1e-12) << t;
    EXPECT_NEAR(value.fddot, 1.4 - 2.4 * t, 1e-11) << t;
  }
}

TEST(TimeFunction, ASplineInOtherUnitsIsTheSameToTheLastDigit) {
  const SplineTable table = table_of([](double t) { return std::sin(3.0 * t); });
  for (const double unit : {0x1p-30, 0x1p30}) {
    std::vector<double> times = kTimes;
    for (double& t : times) t *= unit;
    const SplineTable told(times, table.values());
    for (const double t : {-0.2, 0.1, 0.4, 0.9, 1.3, 1.7, 2.3}) {
      EXPECT_EQ(told.evaluate(unit * t).f, table.evaluate(t).f);
      EXPECT_EQ(told.evaluate(unit * t).fddot * unit * unit, table.evaluate(t).fddot);
    }
  }
}

/// "Then it stays": a last point far away, and no round-off of its distance where the run is.
TEST(TimeFunction, ALongPieceOfASplineIsExactBesideTheShortOnes) {
  const SplineTable held({0.0, 0.1, 0.2, 0.3, 1e6}, {0.0, 0.4, 0.5, 0.5, 0.5});
  const double step = 1e-4;
  for (const double t : {0.3, 0.35, 0.5}) {
    const TimeFunctionValue now = held.evaluate(t);
    const TimeFunctionValue next = held.evaluate(t + step);
    const double third = (next.fddot - now.fddot) / step;
    EXPECT_NEAR(next.f, now.f + step * (now.fdot + step * (now.fddot / 2 + step * third / 6)), 1e-15) << t;
    EXPECT_NEAR(next.fdot, now.fdot + step * (now.fddot + step * third / 2), 1e-14) << t;
  }
  EXPECT_EQ(held.evaluate(0.3).f, 0.5);
  EXPECT_EQ(held.evaluate(1e6).f, 0.5);
}

/// Dead band between long ramps: points of a cubic x^3 + x lie on it whatever their distances.
TEST(TimeFunction, AShortPieceBetweenLongOnesIsResolved) {
  const auto f = [](double x) { return x * x * x + x; };
  for (const double far : {1e2, 1e4}) {
    const std::vector<double> x{-far, -0.1, 0.1, far};
    const SplineTable table(x, {f(x[0]), f(x[1]), f(x[2]), f(x[3])});
    EXPECT_NEAR(table.evaluate(0.05).f, f(0.05), 1e-16 * far * far) << far;
  }
  const SplineTable line({-1e8, -0.1, 0.1, 1e8}, {-1e8, 0.0, 0.0, 1e8});
  EXPECT_NEAR(line.evaluate(0.05).f, 0.0, 1e-12);
}

TEST(TimeFunction, SplineGoesThroughItsTableWithContinuousCurvature) {
  const SplineTable table = table_of([](double t) { return std::sin(3.0 * t); });
  for (const double t : kTimes) EXPECT_NEAR(table.evaluate(t).f, std::sin(3.0 * t), 1e-15);
  for (std::size_t k = 1; k + 1 < kTimes.size(); ++k) {
    const double below = table.evaluate(kTimes[k] - 1e-9).fddot;
    EXPECT_NEAR(below, table.evaluate(kTimes[k] + 1e-9).fddot, 1e-6);
  }
}

}  // namespace
}  // namespace concord
