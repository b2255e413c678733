#include "cartesian/bodies/body_inertia.h"

#include <gtest/gtest.h>

#include "machines.h"

namespace concord::cartesian {
namespace {

using testing::Numbers;

struct BodyMotion {
  Mat3 A;
  Vec3 omega;
  VecX a;
  VecX adot;
};

BodyMotion generic_motion(Numbers& numbers, int m) {
  return {numbers.rotation(), numbers.vector(3.0), numbers.matrix(m, 1, 0.4), numbers.matrix(m, 1, 2.0)};
}

/// Velocity of a mass point over Y, 3 x (6 + m), and its acceleration at Ydot = 0: straight from the kinematics.
MatX point_jacobian(const MassPoint& point, const BodyMotion& motion) {
  const Vec3 s = motion.A * (point.s0_L + point.Psi_t_L * motion.a);
  MatX jacobian(3, 6 + motion.a.size());
  jacobian << Mat3::Identity(), -skew(s), motion.A * point.Psi_t_L;
  return jacobian;
}

Vec3 point_bias(const MassPoint& point, const BodyMotion& motion) {
  const Vec3 s = motion.A * (point.s0_L + point.Psi_t_L * motion.a);
  const Vec3 sdot = motion.A * (point.Psi_t_L * motion.adot);
  return motion.omega.cross(motion.omega.cross(s)) + 2.0 * motion.omega.cross(sdot);
}

void expect_direct_sum(const Body& body, const std::vector<MassPoint>& points, const BodyMotion& motion) {
  const auto m = motion.a.size();
  const Vec3 gravity(0.4, -9.0, 2.0);
  MatX M = MatX::Zero(6 + m, 6 + m);
  VecX force = VecX::Zero(6 + m);
  for (const MassPoint& point : points) {
    const MatX jacobian = point_jacobian(point, motion);
    M += point.mass * jacobian.transpose() * jacobian;
    force += point.mass * jacobian.transpose() * (gravity - point_bias(point, motion));
  }
  if (m > 0) force.tail(m) -= body.modal->stiffness * motion.a + body.modal->damping * motion.adot;

  const BodyInertia constant(body);
  DeformedInertia inertia(constant);
  inertia.update(motion.a, motion.adot);
  MatX computed_M = MatX::Zero(6 + m, 6 + m);
  VecX computed_force = VecX::Zero(6 + m);
  inertia.write_mass_matrix(motion.A, computed_M);
  inertia.write_forces(motion.A, motion.omega, gravity, motion.a, motion.adot, computed_force);
  EXPECT_LT((computed_M - M).norm(), 1e-13 * M.norm());
  EXPECT_LT((computed_force - force).norm(), 1e-13 * force.norm());
}

TEST(BodyInertia, FlexibleEqualsTheDirectSumOverMassPoints) {
  Numbers numbers(29);
  for (int m = 1; m <= 4; ++m) {
    const Body body = testing::make_body(numbers, "flexible", m);
    expect_direct_sum(body, body.modal->mass_points, generic_motion(numbers, m));
  }
}

TEST(BodyInertia, IsThatOfTheUndeformedBodyUntilItIsUpdated) {
  Numbers numbers(30);
  const Body body = testing::make_body(numbers, "flexible", 3);
  const BodyMotion motion = generic_motion(numbers, 3);
  const BodyInertia constant(body);
  const auto mass_matrix = [&](const DeformedInertia& inertia) {
    MatX M(9, 9);
    inertia.write_mass_matrix(motion.A, M);
    return M;
  };
  DeformedInertia inertia(constant);
  const MatX of_new = mass_matrix(inertia);
  inertia.update(motion.a, motion.adot);
  EXPECT_GT((mass_matrix(inertia) - of_new).norm(), 1e-3);
  const VecX none = VecX::Zero(3);
  inertia.update(none, none);
  EXPECT_EQ(mass_matrix(inertia), of_new);
}

TEST(BodyInertia, RigidEqualsSixMassPoints) {
  Numbers numbers(31);
  const Body body = testing::make_body(numbers, "rigid", 0);
  // Second moments P = tr(I)/2 1 - I about the centre of mass, by points at plus and minus c along the principal axes.
  const Eigen::SelfAdjointEigenSolver<Mat3> principal(0.5 * body.inertia_L.trace() * Mat3::Identity() - body.inertia_L);
  std::vector<MassPoint> points;
  for (int k = 0; k < 3; ++k) {
    const Vec3 c = std::sqrt(3.0 * principal.eigenvalues()(k) / body.mass) * principal.eigenvectors().col(k);
    for (const double sign : {-1.0, 1.0}) {
      points.push_back({body.mass / 6.0, body.center_of_mass_L + sign * c, Mat3X(3, 0)});
    }
  }
  expect_direct_sum(body, points, generic_motion(numbers, 0));
}

}  // namespace
}  // namespace concord::cartesian
