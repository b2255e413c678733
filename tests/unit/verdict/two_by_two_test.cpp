#include "compare/verdict/two_by_two.h"

#include <gtest/gtest.h>

#include <string>

#include "compare/verdict/verify.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

/// Two stand-ins, the second one with a fault.
class TwoByTwoTest : public ::testing::Test {
 protected:
  Verdict verdict() {
    VerifyOptions options;
    options.refines = false;
    return verify(model_, right_, wrong_, options);
  }

  Model model_ = pendulum_model();
  FakePendulum right_{model_, "cartesian"};
  FakePendulum wrong_{model_, "relative"};
};

TEST_F(TwoByTwoTest, NothingIsToldWhereNothingDiffers) {
  const Verdict same = verdict();
  EXPECT_FALSE(same.two_by_two);
  EXPECT_FALSE(same.attribution);
}

TEST_F(TwoByTwoTest, AWrongEquationIsFormulation) {
  wrong_.spoil = [](const State&, Evaluation& evaluation) {
    for (SideWrench& side : evaluation.joints[0].reaction) side.in_C.force(0) *= 1.01;
  };
  const Verdict differs = verdict();
  ASSERT_TRUE(differs.two_by_two);
  for (int who = 0; who < 2; ++who) {
    EXPECT_GT(differs.two_by_two->formulation[who], 1e-3);
    EXPECT_LT(differs.two_by_two->integration[who], 1e-6 * differs.two_by_two->formulation[who]);
  }
  EXPECT_NEAR(differs.two_by_two->curves.magnitude, 0.01, 1e-4);
}

/// A solver that moves from another start at every tolerance, while its equations are right.
TEST_F(TwoByTwoTest, AWrongMotionIsIntegration) {
  Model displaced = model_;
  displaced.joints[0].start[0].q(0) += 1e-4;
  FakePendulum elsewhere(displaced, "relative");
  wrong_.spoil_run = [&](Trajectory& run) {
    RunOptions options;
    options.until = run.samples.back().state.t;
    options.samples = static_cast<int>(run.samples.size()) - 1;
    run = elsewhere.integrate(options, {});
  };
  const Verdict differs = verdict();
  ASSERT_TRUE(differs.two_by_two);
  for (int who = 0; who < 2; ++who) {
    EXPECT_GT(differs.two_by_two->integration[who], 1e-6);
    EXPECT_LT(differs.two_by_two->formulation[who], 1e-6 * differs.two_by_two->integration[who]);
  }
}

}  // namespace
}  // namespace concord::compare
