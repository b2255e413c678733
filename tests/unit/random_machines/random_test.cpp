#include "compare/random_machines/random.h"

#include <gtest/gtest.h>

using concord::compare::fuzz::Random;

// Computed by a second program, in exact integers, from the published recurrences of splitmix64 (its first number for
// the seed 1234567 is 6457827717110365317, as printed elsewhere) and xoshiro256**.
TEST(Random, IsTheSameOnEveryComputer) {
  Random random(1, 0);
  EXPECT_EQ(random.bits(), 17154914556750032435U);
  EXPECT_EQ(random.bits(), 15481925071032317162U);
  EXPECT_EQ(random.bits(), 3049712571244418729U);
}

TEST(Random, StreamsDiffer) {
  EXPECT_NE(Random(1, 0).bits(), Random(1, 1).bits());
  EXPECT_NE(Random(1, 0).bits(), Random(2, 0).bits());
  EXPECT_EQ(Random(7, 9).bits(), Random(7, 9).bits());
}

TEST(Random, NumbersStayInTheirRanges) {
  Random random(3, 4);
  double sum = 0.0;
  for (int k = 0; k < 10000; ++k) {
    const double u = random.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    const double v = random.log_between(1e-3, 1e3);
    ASSERT_GE(v, 1e-3);
    ASSERT_LE(v, 1e3);
    const int n = random.below(7);
    ASSERT_GE(n, 0);
    ASSERT_LT(n, 7);
    ASSERT_NEAR(random.rotation().norm(), 1.0, 1e-14);
  }
  EXPECT_NEAR(sum / 10000, 0.5, 0.02);
}
