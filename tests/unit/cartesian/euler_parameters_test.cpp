#include "cartesian/bodies/euler_parameters.h"

#include <gtest/gtest.h>

#include "machines.h"

namespace concord::cartesian {
namespace {

using testing::Numbers;

TEST(EulerParameters, RotateLikeAnAxisAndAnAngle) {
  const Vec3 axis = Vec3(0.3, -0.7, 0.5).normalized();
  const double angle = 2.1;
  Vec4 p;
  p << std::cos(angle / 2), std::sin(angle / 2) * axis;
  EXPECT_LT((rotation_of(p) - rotation_about(axis, angle)).norm(), 1e-15);
}

TEST(EulerParameters, ReadBackFromARotationInEveryQuarter) {
  Numbers numbers(3);
  for (int k = 0; k < 200; ++k) {
    const double angle = numbers.one(EIGEN_PI);
    const Mat3 A = rotation_about(numbers.vector().normalized(), angle);
    const Vec4 p = euler_parameters_of(A);
    EXPECT_GE(p(0), 0.0);
    EXPECT_LT((rotation_of(p) - A).norm(), 4e-15);
  }
}

TEST(EulerParameters, RatesBelongToTheAngularVelocityInGlobalAxes) {
  Numbers numbers(5);
  const Vec4 p = euler_parameters_of(numbers.rotation());
  const Vec3 omega = numbers.vector(3.0);
  const Vec4 pdot = compute_pdot(p, omega);
  EXPECT_NEAR(p.dot(pdot), 0.0, 1e-15);
  EXPECT_LT((2.0 * compute_E(p) * pdot - omega).norm(), 1e-14);
  const double h = 1e-6;
  const Mat3 Adot = (rotation_of(p + h * pdot) - rotation_of(p - h * pdot)) / (2 * h);
  EXPECT_LT((Adot - skew(omega) * rotation_of(p)).norm(), 1e-9);
}

}  // namespace
}  // namespace concord::cartesian
