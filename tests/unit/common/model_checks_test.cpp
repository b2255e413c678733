#include "common/reading/model_checks.h"

#include <gtest/gtest.h>

#include <numbers>

#include "common/joints/spherical.h"
#include "common/rotation.h"

namespace concord {
namespace {

Mat3 turned(const Vec3& principal) {
  const Mat3 A = rotation_about(Vec3(1.0, -2.0, 0.7).normalized(), 0.9);
  return A * principal.asDiagonal() * A.transpose();
}

TEST(ModelChecks, AngleBetweenDirectionsIsExactNearZeroAndPi) {
  const Vec3 a(0.3, -1.2, 2.0);
  EXPECT_DOUBLE_EQ(angle_between(a, 5.0 * a), 0.0);
  EXPECT_DOUBLE_EQ(angle_between(a, -a), std::numbers::pi);
  const Vec3 across = a.cross(Vec3::UnitX()).normalized() * a.norm();
  EXPECT_NEAR(angle_between(a, a + 1e-9 * across), 1e-9, 1e-15);
}

TEST(ModelChecks, AcceptsEveryInertiaThatMassPointsHave) {
  Mat3 second_moment = Mat3::Zero();
  for (const Vec3& s : {Vec3(0.3, 0.1, -0.2), Vec3(-0.1, 0.4, 0.5), Vec3(0.0, -0.6, 0.1)}) {
    second_moment += 0.7 * s * s.transpose();
    EXPECT_EQ(complaint_about_inertia(second_moment.trace() * Mat3::Identity() - second_moment), std::nullopt);
  }
  EXPECT_EQ(complaint_about_inertia(Mat3::Zero()), std::nullopt) << "a mass point";
}

TEST(ModelChecks, RefusesInertiasThatNoMassHas) {
  EXPECT_EQ(complaint_about_inertia(turned({1.0, 2.0, 3.1})),
            "principal moments 1, 2, 3.1 kg m2: the largest exceeds the sum of the others, which no mass distribution "
            "can have");
  EXPECT_EQ(complaint_about_inertia(turned({-1.0, 2.0, 3.0})),
            "principal moments -1, 2, 3 kg m2: none may be negative");
  EXPECT_EQ(complaint_about_inertia(turned({1.0, 2.0, 3.0})), std::nullopt) << "a plate";
}

TEST(ModelChecks, FindsAsymmetry) {
  MatX matrix(2, 2);
  matrix << 1.0, 3.0, 4.0, 2.0;
  EXPECT_EQ(complaint_about_symmetry(matrix), "entries (1, 2) and (2, 1) differ: 3 and 4");
  matrix(1, 0) = 3.0;
  EXPECT_EQ(complaint_about_symmetry(matrix), std::nullopt);
}

TEST(ModelChecks, FindsNegativeEigenvalues) {
  MatX matrix(2, 2);
  matrix << 1.0, 2.0, 2.0, 1.0;
  EXPECT_EQ(complaint_about_semidefiniteness(matrix), "its smallest eigenvalue is -1, its largest 3");
  matrix << 1.0, 1.0, 1.0, 1.0;
  EXPECT_EQ(complaint_about_semidefiniteness(matrix), std::nullopt);
}

Joint between(int parent, int child) {
  Joint joint;
  joint.type = &joints::spherical;
  joint.sides[0].body = parent;
  joint.sides[1].body = child;
  return joint;
}

TEST(ModelChecks, FindsBodiesThatNothingConnectsToGround) {
  Model model;
  model.bodies.resize(6);
  model.joints = {between(4, 3), between(1, 4), between(3, kGround), between(2, 5)};
  EXPECT_EQ(bodies_without_ground(model), (std::vector<int>{2, 5}));
  model.joints.push_back(between(5, 1));
  EXPECT_TRUE(bodies_without_ground(model).empty());
}

}  // namespace
}  // namespace concord
