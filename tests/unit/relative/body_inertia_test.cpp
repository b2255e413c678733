#include "relative/bodies/body_inertia.h"

#include <gtest/gtest.h>

#include "machines.h"

namespace concord::relative {
namespace {

/// M Ydot + S + U - Q of a flexible body by direct sum over its mass points.
VecX sum_over_points(const ModalData& modal, const VecX& a, const VecX& adot, const Mat3& A, const Vec3& omega,
                     const Vec3& gravity, const VecX& Ydot) {
  const Eigen::Index m = a.size();
  VecX sum = VecX::Zero(6 + m);
  for (const MassPoint& p : modal.mass_points) {
    const Vec3 s = A * (p.s0_L + p.Psi_t_L * a);
    const Vec3 rate = A * (p.Psi_t_L * adot);
    const Vec3 acceleration = Ydot.head<3>() + Vec3(Ydot.segment<3>(3)).cross(s) + omega.cross(omega.cross(s)) +
                              2.0 * omega.cross(rate) + A * (p.Psi_t_L * Ydot.tail(m)) - gravity;
    sum.head<3>() += p.mass * acceleration;
    sum.segment<3>(3) += p.mass * s.cross(acceleration);
    sum.tail(m) += p.mass * (A * p.Psi_t_L).transpose() * acceleration;
  }
  sum.tail(m) += modal.stiffness * a + modal.damping * adot;
  return sum;
}

TEST(FlexibleInertia, EqualsTheSumOverMassPoints) {
  test::Numbers numbers(17);
  const int m = 4;
  const Body body = test::flexible_body("bar", m, numbers);
  const VecX a = numbers.vector(m, 0.4);
  const VecX adot = numbers.vector(m, 2.0);
  const Mat3 A = numbers.rotation();
  const Vec3 omega = numbers.vector(3.0);
  const Vec3 gravity = numbers.vector(9.0);
  BodyInertia inertia(body);
  inertia.update(a.data(), adot.data(), A, omega, gravity);
  const FlexibleInertia& flexible = *inertia.flexible();

  MatX M(6 + m, 6 + m);
  Mat6 M_rr;
  inertia.moments().fill(M_rr);
  M << M_rr, flexible.M_ra(), flexible.M_ra().transpose(), flexible.M_aa();
  VecX p(6 + m);
  p << inertia.p(), flexible.p_a();
  const VecX bias = sum_over_points(*body.modal, a, adot, A, omega, gravity, VecX::Zero(6 + m));
  EXPECT_LT((p - bias).norm(), 1e-13 * bias.norm());
  for (Eigen::Index c = 0; c < 6 + m; ++c) {
    const VecX unit = VecX::Unit(6 + m, c);
    const VecX column = sum_over_points(*body.modal, a, adot, A, omega, gravity, unit) - bias;
    EXPECT_LT((M.col(c) - column).norm(), 1e-13 * bias.norm()) << c;
  }
  EXPECT_NEAR(flexible.dissipation(), adot.dot(body.modal->damping * adot), 1e-15);
}

TEST(RigidInertia, ObeysNewtonAndEulerAboutTheCentreOfMass) {
  test::Numbers numbers(8);
  const Body body = test::rigid_body("block", numbers);
  const Mat3 A = numbers.rotation();
  const Vec3 omega = numbers.vector(3.0);
  const Vec3 gravity = numbers.vector(9.0);
  const Vec6 Vdot = (Vec6() << numbers.vector(4.0), numbers.vector(5.0)).finished();
  BodyInertia inertia(body);
  inertia.update(nullptr, nullptr, A, omega, gravity);

  const Vec3 c = A * body.center_of_mass_L;
  const Mat3 I = A * body.inertia_L * A.transpose();
  const Vec3 force =
      body.mass * (Vdot.head<3>() + Vec3(Vdot.tail<3>()).cross(c) + omega.cross(omega.cross(c)) - gravity);
  const Vec3 torque = I * Vdot.tail<3>() + omega.cross(I * omega) + c.cross(force);
  const Vec6 found = inertia.moments().times(Vdot) + inertia.p();
  Mat6 M;
  inertia.moments().fill(M);
  EXPECT_LT((found.head<3>() - force).norm(), 1e-13);
  EXPECT_LT((found.tail<3>() - torque).norm(), 1e-13);
  EXPECT_LT((M * Vdot + inertia.p() - found).norm(), 1e-13);
  EXPECT_EQ(inertia.flexible(), nullptr);
}

}  // namespace
}  // namespace concord::relative
