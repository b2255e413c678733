#include "common/flexible/modal_data.h"

#include <gtest/gtest.h>

#include <random>
#include <stdexcept>

namespace concord {
namespace {

/// Mass points strewn about, each with its own mass and mode shapes.
std::vector<MassPoint> random_points(int count, int n_modes) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto number = [&] { return uniform(generator); };
  std::vector<MassPoint> points;
  for (int k = 0; k < count; ++k) {
    points.push_back({1.5 + number(), Vec3::NullaryExpr(number), Mat3X::NullaryExpr(3, n_modes, number)});
  }
  return points;
}

TEST(MassIntegrals, HoldSumsOverThePoints) {
  const auto points = random_points(9, 2);
  double mass = 0.0;
  Vec3 first_moment = Vec3::Zero();
  Mat3 second_moment = Mat3::Zero();
  Mat3 modes_01 = Mat3::Zero();
  for (const MassPoint& point : points) {
    mass += point.mass;
    first_moment += point.mass * point.s0_L;
    second_moment += point.mass * point.s0_L * point.s0_L.transpose();
    modes_01 += point.mass * point.Psi_t_L.col(0) * point.Psi_t_L.col(1).transpose();
  }
  const MatX G = mass_integrals(points, 2);
  ASSERT_EQ(G.rows(), 10);
  EXPECT_NEAR(G(0, 0), mass, 1e-14 * mass);
  EXPECT_LT((G.block<3, 1>(1, 0) - first_moment).norm(), 1e-14);
  EXPECT_LT((G.block<3, 3>(1, 1) - second_moment).norm(), 1e-13);
  EXPECT_LT((G.block<3, 3>(4, 7) - modes_01).norm(), 1e-13);
  EXPECT_EQ(G, G.transpose());
}

TEST(EquivalentMassPoints, HaveTheSameIntegralsAndEqualMasses) {
  const MatX G = mass_integrals(random_points(60, 3), 3);
  const auto points = equivalent_mass_points(G);
  EXPECT_EQ(points.size(), 13U);
  for (const MassPoint& point : points) EXPECT_NEAR(point.mass, points.front().mass, 1e-15);
  EXPECT_LT((mass_integrals(points, 3) - G).norm(), 1e-13 * G.norm());
}

TEST(EquivalentMassPoints, NeedNoMoreThanTheRank) {
  const MatX G = mass_integrals(random_points(5, 3), 3);
  const auto points = equivalent_mass_points(G);
  EXPECT_EQ(points.size(), 5U);
  EXPECT_LT((mass_integrals(points, 3) - G).norm(), 1e-13 * G.norm());
}

TEST(EquivalentMassPoints, KeepModesThatAreSmallBecauseOfTheirUnit) {
  auto points = random_points(40, 2);
  for (MassPoint& point : points) point.Psi_t_L.col(1) *= 1e-9;
  const MatX G = mass_integrals(points, 2);
  const MatX again = mass_integrals(equivalent_mass_points(G), 2);
  const double small = G.bottomRightCorner<3, 3>().norm();
  EXPECT_LT((again - G).bottomRightCorner(3, 3).norm(), 1e-12 * small);
}

TEST(EquivalentMassPoints, OfOnePointAreThatPoint) {
  const auto one = random_points(1, 1);
  const auto points = equivalent_mass_points(mass_integrals(one, 1));
  ASSERT_EQ(points.size(), 1U);
  EXPECT_NEAR(points[0].mass, one[0].mass, 1e-14);
  EXPECT_LT((points[0].s0_L - one[0].s0_L).norm(), 1e-14);
  EXPECT_LT((points[0].Psi_t_L - one[0].Psi_t_L).norm(), 1e-14);
}

TEST(EquivalentMassPoints, RefuseIntegralsOfNoMassDistribution) {
  MatX G = mass_integrals(random_points(20, 1), 1);
  G(5, 5) = -G(5, 5);
  EXPECT_THROW(equivalent_mass_points(G), std::invalid_argument);
}

}  // namespace
}  // namespace concord
