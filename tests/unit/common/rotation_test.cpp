#include "common/rotation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace concord {
namespace {

TEST(Rotation, SkewIsTheCrossProduct) {
  const Vec3 v(0.3, -1.2, 2.1);
  const Vec3 w(-0.7, 0.4, 1.9);
  EXPECT_EQ(skew(v) * w, v.cross(w));
  EXPECT_EQ(skew(v), -skew(v).transpose());
}

TEST(Rotation, AboutAnAxisIsRightHanded) {
  const double angle = 0.7;
  const Vec3 turned = rotation_about(Axis::x, angle) * Vec3::UnitY();
  EXPECT_LT((turned - Vec3(0.0, std::cos(angle), std::sin(angle))).norm(), 1e-15);
  EXPECT_LT((rotation_about(Axis::y, angle) * Vec3::UnitZ() - Vec3(std::sin(angle), 0.0, std::cos(angle))).norm(),
            1e-15);
  EXPECT_LT((rotation_about(Axis::z, angle) * Vec3::UnitX() - Vec3(std::cos(angle), std::sin(angle), 0.0)).norm(),
            1e-15);
}

TEST(Rotation, AboutATiltedAxisKeepsItAndTurnsByTheAngle) {
  const Vec3 axis = Vec3(1.0, -2.0, 0.5).normalized();
  const Mat3 A = rotation_about(axis, 1.3);
  EXPECT_LT((A * axis - axis).norm(), 1e-15);
  EXPECT_NEAR(A.trace(), 1.0 + 2.0 * std::cos(1.3), 1e-15);
  const Vec3 across = axis.unitOrthogonal();
  EXPECT_NEAR(across.cross(A * across).dot(axis), std::sin(1.3), 1e-15);
}

TEST(Rotation, FromAxesIsOrthonormalAndHasThem) {
  const Vec3 z = Vec3(0.2, 0.9, -0.5).normalized();
  const Vec3 x = z.unitOrthogonal();
  const Mat3 A = rotation_from_x_and_z(x, z);
  EXPECT_EQ(A.col(0), x);
  EXPECT_EQ(A.col(2), z);
  EXPECT_NEAR(A.determinant(), 1.0, 1e-15);
  EXPECT_LT((A.transpose() * A - Mat3::Identity()).norm(), 1e-15);
}

}  // namespace
}  // namespace concord
