#include "compare/resolution/orders.h"

#include <gtest/gtest.h>

#include "compare/verdict/verify.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

TEST(ObservedExponent, IsTheSlopeOfLogarithms) {
  const auto exponent = observed_exponent({1e-6, 1e-8, 1e-10}, {3e-5, 3e-6, 3e-7});
  ASSERT_TRUE(exponent);
  EXPECT_NEAR(*exponent, 0.5, 1e-12);
}

TEST(ObservedExponent, IsMissingWhereErrorsDoNotFall) {
  EXPECT_FALSE(observed_exponent({1e-6, 1e-8, 1e-10}, {3e-5, 3e-6, 2.9e-6}));
  EXPECT_FALSE(observed_exponent({1e-6, 1e-8, 1e-10}, {3e-5, 3e-6, 0.0}));
  EXPECT_FALSE(observed_exponent({1e-6}, {3e-5}));
}

/// Two stand-ins whose angles err by a part of the tolerance, the second one by more.
class OrdersTest : public ::testing::Test {
 protected:
  Verdict verdict(bool asked) {
    VerifyOptions options;
    options.orders = asked;
    return verify(model_, one_, other_, options);
  }

  Model model_ = pendulum_model();
  FakePendulum one_{model_, "cartesian"};
  FakePendulum other_{model_, "relative"};
};

TEST_F(OrdersTest, NothingIsToldUnasked) { EXPECT_FALSE(verdict(false).orders); }

TEST_F(OrdersTest, ErrorsThatFallLikeTheToleranceHaveTheExponentOne) {
  one_.drift = 2.0;
  other_.drift = 5.0;
  const Verdict found = verdict(true);
  EXPECT_EQ(found.outcome, Outcome::agree);
  ASSERT_TRUE(found.orders);
  EXPECT_EQ(found.orders->tolerances.size(), 3u);
  for (const SolverOrders& solver : found.orders->solvers) {
    for (const ObservedOrder* order : {&solver.places, &solver.velocities, &solver.reactions}) {
      ASSERT_TRUE(order->exponent);
      EXPECT_NEAR(*order->exponent, 1.0, 0.01);
    }
  }
  EXPECT_NEAR(found.orders->solvers[1].places.errors[0] / found.orders->solvers[0].places.errors[0], 2.5, 0.01);
}

TEST_F(OrdersTest, RunsThatDoNotDependOnTheToleranceAreOutOfRange) {
  const Verdict found = verdict(true);
  ASSERT_TRUE(found.orders);
  EXPECT_FALSE(found.orders->solvers[0].places.exponent);
  EXPECT_NE(describe(*found.orders)[0].find("not in the range of convergence"), std::string::npos);
}

}  // namespace
}  // namespace concord::compare
