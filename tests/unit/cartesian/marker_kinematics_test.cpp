#include "cartesian/bodies/marker_kinematics.h"

#include <gtest/gtest.h>

#include "machines.h"

namespace concord::cartesian {
namespace {

using testing::Numbers;

TEST(ExponentialMap, SeriesAndClosedFormsMeet) {
  const TangentCoefficients below = tangent_coefficients(1.0 - 1e-15);
  const TangentCoefficients above = tangent_coefficients(1.0);
  EXPECT_NEAR(below.c1, above.c1, 1e-15);
  EXPECT_NEAR(below.c2, above.c2, 1e-15);
  EXPECT_NEAR(below.b1, above.b1, 4e-15);
  EXPECT_NEAR(below.b2, above.b2, 4e-15);
}

TEST(ExponentialMap, IsExactAtTheSmallestAngles) {
  for (const double angle : {0.0, 1e-12, 1e-7, 1e-3, 0.9, 1.1, 3.0}) {
    const Vec3 axis = Vec3(1, -2, 3).normalized();
    EXPECT_LT((exponential_rotation(angle * axis) - rotation_about(axis, angle)).norm(), 3e-15) << angle;
  }
}

TEST(ExponentialMap, TangentGivesRdotRTransposedInBodyAxes) {
  Numbers numbers(7);
  for (const double size : {1e-4, 0.3, 1.5}) {
    const Vec3 theta = numbers.vector(size);
    const Vec3 thetadot = numbers.vector();
    const double h = 1e-6;
    const Mat3 Rdot =
        (exponential_rotation(theta + h * thetadot) - exponential_rotation(theta - h * thetadot)) / (2 * h);
    EXPECT_LT((Rdot * exponential_rotation(theta).transpose() - skew(tangent(theta) * thetadot)).norm(), 1e-9);
    const Vec3 rate = (tangent(theta + h * thetadot) * thetadot - tangent(theta - h * thetadot) * thetadot) / (2 * h);
    EXPECT_LT((rate - tangent_rate_times_thetadot(theta, thetadot)).norm(), 1e-9);
  }
}

/// A body with three modes in motion; everything about its marker against differences of place().
TEST(Marker, VelocitiesAndBiasFollowFromPlaces) {
  Numbers numbers(11);
  Model model;
  model.bodies.push_back(testing::make_body(numbers, "ground", 0));
  model.bodies.push_back(testing::make_body(numbers, "flexible", 3));
  const Attachment attachment = testing::make_attachment(numbers, model, 1);
  const Vec3 r = numbers.vector();
  const Mat3 A = numbers.rotation();
  const Vec3 v = numbers.vector(2.0);
  const Vec3 omega = numbers.vector(3.0);
  const VecX a = numbers.matrix(3, 1, 0.4);
  const VecX adot = numbers.matrix(3, 1, 2.0);
  // The motion with constant v, omega and adot: Ydot = 0.
  const auto at = [&](double t) {
    const Mat3 A_t = rotation_about(omega.normalized(), omega.norm() * t) * A;
    Marker marker = make_marker(attachment);
    const VecX a_t = a + t * adot;
    place(attachment, Vec3(r + t * v), A_t, a_t, marker);
    move(attachment, A_t, v, omega, adot, marker);
    return marker;
  };
  const Marker marker = at(0.0);
  const double h = 1e-5;
  const Marker after = at(h);
  const Marker before = at(-h);
  EXPECT_LT(((after.point - before.point) / (2 * h) - marker.velocity).norm(), 1e-7);
  EXPECT_LT(((after.velocity - before.velocity) / (2 * h) - marker.velocity_bias).norm(), 1e-6);
  EXPECT_LT(((after.A_joint - before.A_joint) / (2 * h) - skew(marker.angular_velocity) * marker.A_joint).norm(), 1e-7);
  EXPECT_LT(((after.angular_velocity - before.angular_velocity) / (2 * h) - marker.angular_velocity_bias).norm(), 1e-6);
}

TEST(Marker, RefusesARotationOfPiByDeformation) {
  Attachment attachment;
  attachment.body = 1;
  attachment.Psi_t_L = Mat3X::Zero(3, 1);
  attachment.Psi_r_L = Vec3(0, 0, 1);
  Marker marker = make_marker(attachment);
  const VecX a = VecX::Constant(1, 3.2);
  EXPECT_THROW(place(attachment, Vec3(Vec3::Zero()), Mat3(Mat3::Identity()), a, marker), SolverError);
}

}  // namespace
}  // namespace concord::cartesian
