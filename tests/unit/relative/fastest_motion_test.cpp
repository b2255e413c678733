#include "relative/run/fastest_motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "machines.h"
#include "relative/start/assembly.h"

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

TEST(FastestMotionTest, NamesTheJointThatIsTooStiff) {
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
TEST(FastestMotionTest, SeesTheSpringOfAFreeBody) {
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

TEST(FastestMotionTest, IsNamedWhereARunIsCostly) {
  Started at{{4e8, 0.0}};
  const std::string text = place_of_cost(at.equations, at.start);
  EXPECT_TRUE(text.starts_with("; the fastest motion there is that of joint 'elbow', at ")) << text;
}

}  // namespace
}  // namespace concord::relative
