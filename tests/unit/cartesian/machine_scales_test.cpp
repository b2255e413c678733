#include "cartesian/bodies/machine_scales.h"

#include <gtest/gtest.h>

#include "common/joints/revolute.h"
#include "common/joints/translational.h"

namespace concord::cartesian {
namespace {

/// A machine that its driver brings to rest has no speed that small ones could be compared with, but this rate.
double rate_by(const joints::JointType& type, const TimeFunction& law, double length) {
  Model model;
  model.bodies.resize(2);
  Joint joint;
  joint.type = &type;
  joint.sides[index(Side::child)].body = 1;
  joint.sides[index(Side::child)].point_L = Vec3(0.0, -length, 0.0);
  joint.drivers.push_back({0, law, 0});
  model.joints.push_back(joint);
  EXPECT_DOUBLE_EQ(model.length_scale(), length);
  return rate_of_drivers(model);
}

TEST(DrivenRate, OfATurnIsCountedInRadians) {
  const auto rate = [](const TimeFunction& law) { return rate_by(joints::revolute, law, 0.4); };
  EXPECT_DOUBLE_EQ(rate(ConstantSpeed{3.0, -0.8}), 0.8);
  EXPECT_DOUBLE_EQ(rate(Harmonic{1.0, 0.3, 7.0, 0.2}), 2.1);
  EXPECT_DOUBLE_EQ(rate(SmoothStep{0.1, 0.6, 1.5, 0.5}), 2.0);
  EXPECT_DOUBLE_EQ(rate(Polynomial{{9.0, 0.2, 0.0, 4.0 / 3.0}}), 2.0);  // 3! 4/3 = 2^3
  EXPECT_DOUBLE_EQ(rate(SplineTable({0.0, 0.5, 0.6, 1.0}, {0.0, 0.1, 0.4, 0.4})), 3.0);
  EXPECT_EQ(rate(Polynomial{{9.0}}), 0.0);
}

TEST(DrivenRate, OfASlideIsCountedInLengthsOfTheMachine) {
  const auto rate = [](const TimeFunction& law) { return rate_by(joints::translational, law, 0.4); };
  EXPECT_DOUBLE_EQ(rate(ConstantSpeed{3.0, -0.8}), 2.0);
  EXPECT_DOUBLE_EQ(rate(Harmonic{1.0, 0.3, 7.0, 0.2}), 5.25);
  EXPECT_DOUBLE_EQ(rate(SmoothStep{0.1, 0.6, 1.5, 0.5}), 5.0);
  EXPECT_DOUBLE_EQ(rate(Polynomial{{9.0, 0.2, 0.0, 8.0 / 15.0}}), 2.0);  // 3! 8/15 / 0.4 = 2^3
  EXPECT_DOUBLE_EQ(rate(SplineTable({0.0, 0.5, 0.6, 1.0}, {0.0, 0.1, 0.4, 0.4})), 7.5);
}

}  // namespace
}  // namespace concord::cartesian
