#include "relative/evaluation_limit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "machines.h"
#include "relative/assembly.h"

namespace concord::relative {
namespace {

/// Two bodies in a row, the second on a spring of `stiffness` against a damper of `damping`.
struct TwoOnHinges {
  Model model;

  TwoOnHinges(double stiffness, double damping) {
    test::Numbers numbers(71);
    model.file = "two.toml";
    model.bodies = {test::ground(), test::rigid_body("first", numbers), test::rigid_body("second", numbers)};
    model.joints = {test::joint(model, "shoulder", "revolute", 0, 1, numbers),
                    test::joint(model, "elbow", "revolute", 1, 2, numbers)};
    JointSpring spring;
    spring.law.stiffness = stiffness;
    spring.law.damping = damping;
    model.joints[1].springs = {spring};
  }
};

/// Such a machine at its start.
struct Started {
  TwoOnHinges machine;
  Equations equations{machine.model};
  Assembly assembly{equations};
  Coordinates start = assembly.start();
};

FastestMotion fastest_of(const Model& model) {
  Equations equations(model);
  Assembly assembly(equations);
  return fastest_motion(equations, assembly.start());
}

TEST(RelativeEvaluationLimit, NamesTheJointThatIsTooStiff) {
  const TwoOnHinges one(4e8, 0.0);
  const TwoOnHinges hundredfold(4e10, 0.0);
  const FastestMotion found = fastest_of(one.model);
  EXPECT_EQ(found.of, "joint 'elbow'");
  EXPECT_NEAR(fastest_of(hundredfold.model).rate, 10.0 * found.rate, 1e-3 * found.rate);
  const TwoOnHinges damped(0.0, 3e6);
  const TwoOnHinges tenfold(0.0, 3e7);
  EXPECT_EQ(fastest_of(damped.model).of, "joint 'elbow'");
  EXPECT_NEAR(fastest_of(tenfold.model).rate / fastest_of(damped.model).rate, 10.0, 1e-3);
}

/// A ball has four coordinates to three speeds: the slides beside it are displaced all the same.
TEST(RelativeEvaluationLimit, SeesTheSpringOfAFreeBody) {
  const auto rate_of = [](double stiffness) {
    test::Numbers numbers(72);
    Model model;
    model.file = "one.toml";
    model.bodies = {test::ground(), test::rigid_body("body", numbers)};
    model.joints = {test::joint(model, "loose", "free", 0, 1, numbers)};
    JointSpring spring;
    spring.law.stiffness = stiffness;
    model.joints[0].springs = {spring};
    const FastestMotion found = fastest_of(model);
    EXPECT_EQ(found.of, "joint 'loose'");
    return found.rate;
  };
  EXPECT_GT(rate_of(4e8), 1e3);
  EXPECT_NEAR(rate_of(4e10) / rate_of(4e8), 10.0, 1e-3);
}

TEST(RelativeEvaluationLimit, RefusesARunThatIsHardThroughoutAndSaysWhere) {
  Started at{{4e8, 0.0}};
  EvaluationLimit limit(2.0, "erk");
  long evaluations = 0;
  double t = 0.0;
  try {
    for (; t < 2.0; t += 1e-4) limit.pass(t, evaluations += 4000, at.equations, at.start);  // 80 million in all
    FAIL() << "80 million evaluations were let pass";
  } catch (const TooManyEvaluations& error) {
    const std::string text = error.what();
    EXPECT_TRUE(
        text.starts_with("400000 evaluations were needed for 1.0e-02 s: the run is long beside the motion, or the "
                         "motion locks there, or is too stiff "
                         "for erk; the fastest motion there is that of joint 'elbow', at "))
        << text;
  }
  EXPECT_LT(t, 0.05);
}

TEST(RelativeEvaluationLimit, HoldsTheWholeRunToWhatItWasGiven) {
  Started at{{3.0, 0.1}};
  EvaluationLimit limit(2.0, "erk", 100'000);
  EXPECT_NO_THROW(limit.pass(0.9, 100'000, at.equations, at.start));
  EXPECT_THROW(limit.pass(0.91, 100'001, at.equations, at.start), TooManyEvaluations);
}

TEST(RelativeEvaluationLimit, ForeseesWhatIsNotEnoughAfterATenthOfIt) {
  Started at{{3.0, 0.1}};
  EvaluationLimit limit(2.0, "erk", 100'000, true);
  EXPECT_NO_THROW(limit.pass(0.05, 9'900, at.equations, at.start));  // too early to tell
  EXPECT_NO_THROW(limit.pass(0.11, 10'100, at.equations, at.start));
  EXPECT_THROW(limit.pass(0.1, 10'100, at.equations, at.start), EvaluationsSpent);  // 202000 in all
}

TEST(RelativeEvaluationLimit, LetsAShortHardPhasePass) {
  Started at{{3.0, 0.1}};
  EvaluationLimit limit(2.0, "erk");
  long evaluations = 250'000;
  limit.pass(1e-5, evaluations, at.equations, at.start);
  for (double t = 1e-3; t < 2.0; t += 1e-3) limit.pass(t, evaluations += 400, at.equations, at.start);
}

}  // namespace
}  // namespace concord::relative
