#include "compare/audit/kept_start.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/joints/catalogue.h"
#include "common/reading/model_file.h"

namespace concord::compare {
namespace {

constexpr const char* kSwing = R"(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "bob"
mass = 2.0
inertia = [0.1, 0.2, 0.3]
[[body]]
name = "ball"
mass = 1.0
inertia = [0.1, 0.1, 0.1]
[[joint]]
name = "rod"
type = "cylindrical"
parent = "ground"
child = { body = "bob", point = [1, 0, 0] }
start.turn_z = { keep = 0.7, keep_speed = -2.0 }
start.slide_z = { guess = 0.3 }
[[joint]]
name = "socket"
type = "spherical"
parent = "bob"
child = "ball"
start.ball = { keep = { axis = [0, 0, 1], angle = "90 deg" }, keep_speed = [1, 2, 3] }
)";

class KeptStartTest : public ::testing::Test {
 protected:
  KeptStartTest() : model_(parse_model(kSwing, "swing.toml")) {
    start_.bodies.resize(3);
    start_.bodies[1].v = Vec3(0.0, 2.0, 0.0);
    for (BodyState& body : start_.bodies) body.a = body.adot = VecX(0);
    start_.q = {VecX(Eigen::Vector2d(0.0, 0.7)), VecX(Vec4(std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)))};
    start_.u = {VecX(Eigen::Vector2d(0.0, -2.0)), VecX(Vec3(1.0, 2.0, 3.0))};
  }

  [[nodiscard]] KeptStart found() const { return audit_kept_start(model_, start_); }

  Model model_;
  State start_;
};

TEST_F(KeptStartTest, HoldsWhatIsKeptAndNotWhatIsGuessed) {
  EXPECT_TRUE(found().holds());
  start_.q[0](0) = 5.0;
  start_.u[0](0) = 5.0;
  EXPECT_TRUE(found().holds());
}

TEST_F(KeptStartTest, NamesTheCoordinateThatIsOff) {
  start_.q[0](1) = 0.8;
  EXPECT_FALSE(found().holds());
  EXPECT_EQ(found().owner, "joint rod");
  EXPECT_THAT(found().text(), ::testing::HasSubstr("joint rod, turn_z: 0.8 in place of 0.7"));
}

TEST_F(KeptStartTest, NamesTheSpeedThatIsOff) {
  start_.u[1](2) = -3.0;
  EXPECT_THAT(found().text(), ::testing::HasSubstr("joint socket, speed of ball: -3 in place of 3"));
}

TEST_F(KeptStartTest, TakesAnOrientationOfEitherSign) {
  start_.q[1] *= -1.0;
  EXPECT_TRUE(found().holds());
  start_.q[1] = Vec4(1.0, 0.0, 0.0, 0.0);
  EXPECT_NEAR(found().off, 0.5 * EIGEN_PI, 1e-12);
}

TEST_F(KeptStartTest, HoldsDriversToTheirLaws) {
  model_.joints[0].start[0] = {};
  model_.joints[0].drivers.push_back({0, ConstantSpeed{0.25, 3.0}, 0});
  start_.q[0](0) = 0.25;
  start_.u[0](0) = 3.0;
  EXPECT_TRUE(found().holds());
  start_.u[0](0) = 2.0;
  EXPECT_THAT(found().what, "speed of driver");
}

TEST_F(KeptStartTest, HoldsModalCoordinatesAndTheirRates) {
  ModalData& modal = model_.bodies[2].modal.emplace();
  modal.stiffness = MatX::Identity(2, 2);
  modal.G = MatX::Identity(10, 10);
  model_.bodies[2].a_start = Eigen::Vector2d(1e-5, 0.0);
  model_.bodies[2].adot_start = Eigen::Vector2d(0.0, 2e-3);
  start_.bodies[2].a = model_.bodies[2].a_start;
  start_.bodies[2].adot = model_.bodies[2].adot_start;
  EXPECT_TRUE(found().holds());
  start_.bodies[2].adot.setZero();
  EXPECT_EQ(found().owner, "body ball");
  EXPECT_EQ(found().what, "adot_2");
}

/// Modes that rest have coordinates of round-off: they are compared with what displaces the body.
TEST_F(KeptStartTest, TakesRoundOffOfModesForRest) {
  ModalData& modal = model_.bodies[2].modal.emplace();
  modal.stiffness = MatX::Identity(2, 2);
  modal.G = MatX::Identity(10, 10);
  modal.mass_points.push_back({1.0, Vec3::Zero(), Mat3X::Identity(3, 2)});
  model_.bodies[2].a_start = model_.bodies[2].adot_start = VecX::Zero(2);
  start_.bodies[2].a = start_.bodies[2].adot = VecX::Constant(2, 1e-17);
  EXPECT_TRUE(found().holds());
  start_.bodies[2].a(1) = 1e-10;
  EXPECT_EQ(found().what, "a_2");
  EXPECT_FALSE(found().holds());
}

/// A machine at rest has speeds of round-off.
TEST_F(KeptStartTest, TakesRoundOffOfSpeedsForRest) {
  start_.bodies[1].v.setZero();
  model_.joints[0].start[1].u.setZero();
  start_.u[0](1) = 1e-16;
  EXPECT_TRUE(found().holds());
}

TEST_F(KeptStartTest, IsNothingOfARunWithoutSamples) { EXPECT_TRUE(audit_kept_start(model_, Trajectory{}).holds()); }

}  // namespace
}  // namespace concord::compare
