#include "relative/bodies/exponential_map.h"

#include <gtest/gtest.h>

#include <numbers>

#include "machines.h"

namespace concord::relative {
namespace {

Vec3 axial(const Mat3& W) { return 0.5 * Vec3(W(2, 1) - W(1, 2), W(0, 2) - W(2, 0), W(1, 0) - W(0, 1)); }

const Vec3 kDirection = Vec3(0.3, -0.7, 0.5).normalized();

TEST(ExponentialMap, RotatesAboutTheVectorByItsLength) {
  for (const double t : {0.0, 1e-9, 1e-4, 0.3, 0.999, 1.001, 2.0, 3.1}) {
    const Mat3 expected = rotation_about(kDirection, t);
    EXPECT_LT((exponential_map(t * kDirection).R - expected).norm(), 1e-15) << t;
  }
}

TEST(ExponentialMap, TangentIsTheIntegralOfTheRotation) {
  for (const double t : {0.0, 1e-8, 1e-3, 0.5, 0.9999, 1.0001, 2.2, 3.1}) {
    const Mat3 expected = test::tangent_by_quadrature(t * kDirection);
    EXPECT_LT((exponential_map(t * kDirection).J - expected).norm(), 1e-14) << t;
  }
}

TEST(ExponentialMap, TangentGivesTheAngularVelocityInBodyAxes) {
  const Vec3 theta(0.4, -0.9, 0.6);
  const Vec3 rate(-1.1, 0.5, 0.8);
  const double h = 1e-5;
  const Mat3 Rdot = (exponential_map(theta + h * rate).R - exponential_map(theta - h * rate).R) / (2.0 * h);
  const ExponentialMap map = exponential_map(theta);
  EXPECT_LT((axial(Rdot * map.R.transpose()) - map.J * rate).norm(), 1e-9);
  EXPECT_GT((axial(Rdot * map.R.transpose()) - map.J.transpose() * rate).norm(), 0.1);
}

TEST(ExponentialMap, TangentRateIsTheDerivativeOfTheTangent) {
  const Vec3 rate(-1.1, 0.5, 0.8);
  for (const double t : {0.0, 1e-7, 0.2, 0.97, 1.03, 2.5}) {
    const Vec3 theta = t * kDirection;
    const double h = 1e-4;
    const auto J = [&](double s) { return exponential_map(theta + s * rate).J; };
    const Mat3 expected = (8.0 * (J(h) - J(-h)) - (J(2 * h) - J(-2 * h))) / (12.0 * h);
    EXPECT_LT((tangent_rate(theta, rate) - expected).norm(), 1e-11) << t;
  }
}

TEST(RotationVector, InvertsTheMapUpToHalfATurn) {
  for (const double t : {0.0, 1e-14, 1e-7, 0.4, 2.0, 3.1, 3.1415}) {
    const Vec3 theta = t * kDirection;
    EXPECT_LT((rotation_vector(exponential_map(theta).R) - theta).norm(), 1e-15 + 1e-15 * t) << t;
  }
  EXPECT_NEAR(rotation_vector(rotation_about(kDirection, std::numbers::pi)).norm(), std::numbers::pi, 1e-14);
}

TEST(EulerParameters, AreThoseOfTheRotationOnTheNearestSheet) {
  const Mat3 R = rotation_about(kDirection, 2.9);
  const Vec4 p = euler_parameters(R, Vec4(1, 0, 0, 0));
  EXPECT_NEAR(p.norm(), 1.0, 1e-15);
  EXPECT_LT((rotation_from_euler_parameters(3.7 * p) - R).norm(), 1e-15);
  EXPECT_LT((euler_parameters(R, -p) + p).norm(), 1e-15);
}

}  // namespace
}  // namespace concord::relative
