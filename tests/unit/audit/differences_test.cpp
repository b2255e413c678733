#include "compare/audit/differences.h"

#include <gtest/gtest.h>

#include <cmath>

namespace concord::compare {
namespace {

VecX one(double value) { return VecX::Constant(1, value); }

TEST(SlopeMisfit, ASmoothSlopeIsFoundWithTheFirstStepAndLittleDoubt) {
  const auto f = [](double h) { return one(std::sin(3.0 * h)); };
  const SlopeMisfit found = slope_misfit(f, one(3.0), one(9.0), 5e-4, 1e-11);
  EXPECT_NEAR(found.slope(0), 3.0, 1e-10);
  EXPECT_DOUBLE_EQ(found.doubt(0), 9e-11);
}

TEST(SlopeMisfit, NoiseOfTheFunctionIsTold) {
  int calls = 0;
  const auto noisy = [&](double h) { return one(std::sin(3.0 * h) + 1e-10 * std::sin(1e3 * ++calls)); };
  const SlopeMisfit found = slope_misfit(noisy, one(3.0), one(9.0), 5e-4, 1e-11);
  EXPECT_GT(found.doubt(0), 1e-9);
  EXPECT_LT(found.doubt(0), 1e-4);
  EXPECT_LT(std::abs(found.slope(0) - 3.0), 1e-4);
}

TEST(SlopeMisfit, AWrongSlopeExceedsTheDoubt) {
  const auto f = [](double h) { return one(std::sin(3.0 * h)); };
  const SlopeMisfit found = slope_misfit(f, one(3.0 + 1e-5), one(9.0), 5e-4, 1e-11);
  EXPECT_GT(std::abs(found.slope(0) - (3.0 + 1e-5)), 100.0 * found.doubt(0));
}

TEST(SlopeMisfit, AKinkOnOneSideSpoilsNothing) {
  const auto kinked = [](double h) { return one(h > 0.0 ? 2.0 * h + 40.0 * h * h : 2.0 * h); };
  EXPECT_LT(slope_misfit(kinked, one(2.0), one(4.0), 1e-3, 1e-11).size, 1e-10);
}

TEST(SlopeMisfit, AWantedSlopeIsTakenWhereNeighbouringQuotientsAgree) {
  // A short wave in the wanted entry: long steps alias it, although the entry that is known is right with all of them.
  const auto f = [](double x) {
    VecX values(2);
    values << 3.0 * x, std::sin(4e4 * x);
    return values;
  };
  VecX expected(2);
  expected << 3.0, std::numeric_limits<double>::infinity();
  VecX scales(2);
  scales << 9.0, 4e4;
  const SlopeMisfit found = slope_misfit(f, expected, scales, 5e-4, 1e-11);
  EXPECT_LT(found.size, 1e-11);
  EXPECT_NEAR(found.slope(1), 4e4, 1e-5);
  EXPECT_LT(found.doubt(1), 1e-4);
}

}  // namespace
}  // namespace concord::compare
