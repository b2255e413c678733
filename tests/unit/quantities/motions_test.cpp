#include "compare/quantities/motions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "compare/resolution/resolution.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

class MotionsTest : public ::testing::Test {
 protected:
  Trajectory run() {
    return FakePendulum(model_, "cartesian").integrate({0.2, 1e-11, 20, ""}, [](double) {});
  }

  Model model_ = pendulum_model();
};

TEST_F(MotionsTest, AngleIsAccurateNearZeroAndNearHalfATurn) {
  const Mat3 A = rotation_about(Vec3(1, 2, 2) / 3.0, 0.7);
  const Vec3 axis = Vec3(2, -1, 2) / 3.0;
  for (const double angle : {0.0, 1e-13, 1e-3, 1.5, 3.14}) {
    EXPECT_NEAR(angle_between(A, A * rotation_about(axis, angle)), angle, 1e-15 + 1e-14 * angle);
  }
}

TEST_F(MotionsTest, ComparesMotions) {
  const Trajectory one = run();
  const MotionAgreement same = compare_motions(model_, {&one, &one});
  EXPECT_EQ(same.digits, 16.0);
  Trajectory other = one;
  other.samples[9].state.bodies[1].r(1) += 1e-5 * model_.length_scale();
  const MotionAgreement moved = compare_motions(model_, {&one, &other});
  EXPECT_NEAR(moved.digits, 5.0, 1e-9);
  EXPECT_EQ(moved.worst, "origin of bob");
  EXPECT_DOUBLE_EQ(moved.t, one.samples[9].state.t);
  other.samples[9].state.bodies[1].p *= -1.0;  // the same orientation
  EXPECT_NEAR(compare_motions(model_, {&one, &other}).digits, 5.0, 1e-9);
}

/// A body that travels far is compared with the way that it goes.
TEST_F(MotionsTest, PlacesAreComparedWithTheWayTravelled) {
  const double far = 1e3 * model_.length_scale();
  Trajectory one = run();
  for (std::size_t k = 0; k < one.samples.size(); ++k) {
    one.samples[k].state.bodies[1].r(0) += far * static_cast<double>(k) / static_cast<double>(one.samples.size() - 1);
  }
  Trajectory other = one;
  other.samples[9].state.bodies[1].r(1) += 1e-5 * model_.length_scale();
  EXPECT_NEAR(compare_motions(model_, {&one, &other}).digits, 8.0, 1e-2);
}

/// A spring makes of what a run leaves open of a place an acceleration, and of that a speed: what it explains is no
/// difference.
TEST_F(MotionsTest, SpeedsOfAStiffSpringAreKnownToItsFrequencyTimesThePlace) {
  const QuantityLayout layout(model_);
  const Trajectory one = run();
  constexpr double kFrequency = 1e5;  // rad/s
  const double place = kUnitsOfARun * std::numeric_limits<double>::epsilon() *
                       std::max(model_.length_scale(), one.samples[9].state.bodies[1].r.cwiseAbs().maxCoeff());
  MatX resolution = MatX::Zero(static_cast<Eigen::Index>(layout.quantities().size()), 21);
  resolution.middleRows<3>(layout.first_row(Kind::acceleration, 1)).setConstant(kFrequency * kFrequency * place);
  resolution.col(3).setConstant(std::numeric_limits<double>::quiet_NaN());
  const MatX noise = noise_of_speeds(layout, resolution, one);
  EXPECT_NEAR(noise(2, 9) / (kFrequency * place), 1.0, 1e-12);
  EXPECT_EQ(noise(3, 9), 0.0);
  EXPECT_EQ(noise(2, 3), 0.0);

  Trajectory other = one;
  other.samples[9].state.bodies[1].v(1) += 0.9 * kFrequency * place;
  EXPECT_LT(compare_motions(model_, {&one, &other}).digits, 11.0);
  EXPECT_EQ(compare_motions(model_, {&one, &other}, noise).digits, 16.0);
  other.samples[9].state.bodies[1].v(1) += 0.2 * kFrequency * place;
  EXPECT_LT(compare_motions(model_, {&one, &other}, noise).digits, 11.0);
  other = one;
  other.samples[3].state.bodies[1].v(1) += 0.9 * kFrequency * place;
  EXPECT_LT(compare_motions(model_, {&one, &other}, noise).digits, 11.0);
}

/// Far from the origin the last digits of places, and what they leave of orientations, are no difference.
TEST_F(MotionsTest, FarFromTheOriginPlacesAreKnownToTheirRoundOff) {
  const double far = 1e7 * model_.length_scale();
  Trajectory one = run();
  for (Sample& sample : one.samples) sample.state.bodies[1].r(0) += far;
  Trajectory other = one;
  BodyState& body = other.samples[9].state.bodies[1];
  body.r(1) += 2e-7 * model_.length_scale();
  body.p(1) += 1e-7;
  EXPECT_EQ(compare_motions(model_, {&one, &other}).digits, 16.0);
  body.r(1) += 1e-5 * model_.length_scale();
  EXPECT_NEAR(compare_motions(model_, {&one, &other}).digits, 5.0, 0.1);
  body.r(1) = one.samples[9].state.bodies[1].r(1);
  body.p(1) += 1e-5;
  EXPECT_EQ(compare_motions(model_, {&one, &other}).worst, "orientation of bob");
}

}  // namespace
}  // namespace concord::compare
