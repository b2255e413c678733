#include "compare/audit/round_off.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace concord::compare {
namespace {

/// A solver whose answers hold so much noise: the k-th draw is told by its time alone.
Redraw drawn() {
  return [](const State& state, int k) {
    State moved = state;
    moved.t = k + 1.0;
    return std::optional(std::pair{moved, Evaluation{}});
  };
}

Balance balance_of(double residual, double scale) {
  Balance balance(0);
  balance.rows.setConstant(residual);
  balance.scales.setConstant(scale);
  return balance;
}

/// What is left over in the draws: `fault` in all of them, noise of this size besides.
auto left_over(double fault, double noise) {
  return [fault, noise](const State& moved, const Evaluation&) {
    return VecX(VecX::Constant(6, fault + noise * std::cos(3.0 * moved.t)));
  };
}

TEST(RoundOff, ABreachIsSuspectedBelowTheNeedAlone) {
  EXPECT_FALSE(is_suspicious(balance_of(0.9e-9, 1.0)));
  EXPECT_TRUE(is_suspicious(balance_of(1.1e-9, 1.0)));
  EXPECT_TRUE(is_suspicious(balance_of(std::numeric_limits<double>::quiet_NaN(), 1.0)));
}

TEST(RoundOff, WhatChangesWithTheLastDigitsOfTheStateIsNoBreach) {
  const State state;
  const Redraw redraw = drawn();
  OwnRoundOff own(state, redraw);
  EXPECT_TRUE(own.unexplained(balance_of(3e-8, 1.0), left_over(0.0, 3e-8)).isZero(0.0));
}

TEST(RoundOff, AFaultStaysThoughTheSolverIsNoisy) {
  const State state;
  const Redraw redraw = drawn();
  OwnRoundOff own(state, redraw);
  const Balance faulty = balance_of(5e-7, 1.0);
  EXPECT_EQ(own.unexplained(faulty, left_over(5e-7, 1e-8)), faulty.rows);
}

TEST(RoundOff, WhatNoSoundSolverLeavesOverIsABreachWhateverTheNoise) {
  const State state;
  const Redraw redraw = drawn();
  OwnRoundOff own(state, redraw);
  const Balance rough = balance_of(2e-6, 1.0);
  EXPECT_EQ(own.unexplained(rough, left_over(0.0, 1e-3)), rough.rows);
}

TEST(RoundOff, WithoutAnotherAnswerNothingIsExplained) {
  const State state;
  const Redraw none;
  OwnRoundOff own(state, none);
  const Balance balance = balance_of(3e-8, 1.0);
  EXPECT_EQ(own.unexplained(balance, left_over(0.0, 3e-8)), balance.rows);
}

TEST(RoundOff, IsAskedForOnceInAState) {
  int asked = 0;
  const State state;
  const Redraw redraw = [&](const State& at, int k) {
    ++asked;
    return drawn()(at, k);
  };
  OwnRoundOff own(state, redraw);
  (void)own.unexplained(balance_of(3e-8, 1.0), left_over(0.0, 3e-8));
  (void)own.unexplained(balance_of(4e-8, 1.0), left_over(0.0, 3e-8));
  EXPECT_EQ(asked, 5);
}

}  // namespace
}  // namespace concord::compare
