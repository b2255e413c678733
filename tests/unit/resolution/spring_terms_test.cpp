#include "compare/resolution/spring_terms.h"

#include <gtest/gtest.h>

#include "common/joints/catalogue.h"
#include "common/reading/model_file.h"

namespace concord::compare {
namespace {

constexpr const char* kSprung = R"(format = 1
[[body]]
name = "block"
mass = 2.0
inertia = [0.1, 0.2, 0.3]
[[joint]]
name = "guide"
type = "cylindrical"
parent = "ground"
child = "block"
start.slide_z = { keep = -0.4 }
spring.slide_z = { stiffness = 500.0, free = -0.3, preload = 20.0 }
spring.turn_z = { stiffness = 7.0, free = 2.0 }
[[line_spring]]
name = "line"
parent = { body = "ground", point = [0, 3, 0] }
child = { body = "block", point = [4, 0, 0] }
stiffness = 10.0
free = 5.0
[[turn_spring]]
name = "turn"
parent = "ground"
child = "block"
stiffness = 4.0
free = 0.5
[[bushing]]
name = "bushing"
parent = "ground"
child = { body = "block", point = [0, 0, 2] }
stiffness = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
preload = [0.0, 0.0, 0.0, 0.0, 0.0, 9.0]
[[load]]
name = "load"
body = "block"
force = [1, 2, 3]
[[road]]
name = "road"
profile = "flat"
[[tire]]
name = "tire"
road = "road"
body = "block"
radius = 0.3
stiffness = 200.0
slip_stiffness = 1.0
cornering_stiffness = 1.0
friction = 0.8
speed_scale = 0.1
)";

class SpringTermsTest : public ::testing::Test {
 protected:
  SpringTermsTest() : model_(parse_model(kSprung, "sprung.toml")) {
    state_.bodies.resize(2);
    state_.bodies[1].a = state_.bodies[1].adot = VecX(0);
  }

  [[nodiscard]] SpringTerms of_element(std::size_t k) const {
    return spring_terms(model_.elements[k], state_, state_.known_angle(k));
  }

  Model model_;
  State state_;
};

TEST_F(SpringTermsTest, ALineSpringAddsUpItsLengthAndItsFreeLength) {
  EXPECT_DOUBLE_EQ(of_element(0).force, 10.0 * (5.0 + 5.0));
  EXPECT_EQ(of_element(0).torque, 0.0);
}

TEST_F(SpringTermsTest, ATurnSpringAddsUpARadianAndItsFreeAngle) {
  EXPECT_EQ(of_element(1).force, 0.0);
  EXPECT_DOUBLE_EQ(of_element(1).torque, 4.0 * (1.0 + 0.5));
}

TEST_F(SpringTermsTest, ABushingAddsUpItsMotionsAndItsPreload) {
  EXPECT_DOUBLE_EQ(of_element(2).force, 3.0 * 2.0);
  EXPECT_DOUBLE_EQ(of_element(2).torque, 6.0 + 9.0);
}

TEST_F(SpringTermsTest, ALoadHasNone) {
  EXPECT_EQ(of_element(3).force, 0.0);
  EXPECT_EQ(of_element(3).torque, 0.0);
}

TEST_F(SpringTermsTest, ATireTakesItsHeightFromItsRadius) {
  EXPECT_DOUBLE_EQ(of_element(4).force, 200.0 * 0.3);
  EXPECT_DOUBLE_EQ(of_element(4).torque, 200.0 * 0.3 * 0.3);
}

TEST_F(SpringTermsTest, SpringsOfAJointCountForForceOrTorqueByTheirCoordinate) {
  const SpringTerms terms = spring_terms(model_.joints[0], Eigen::Vector2d(-0.4, 0.1), Eigen::Vector2d(0.0, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(terms.force, 500.0 * (0.4 + 0.3) + 20.0);
  EXPECT_DOUBLE_EQ(terms.torque, 7.0 * (0.1 + 2.0));
}

/// A motor that keeps a speed against a damper leaves the difference of two large forces.
TEST_F(SpringTermsTest, DampersAddUpWhatTheirSpeedsGive) {
  model_.joints[0].springs[0].law.damping = 40.0;
  const SpringTerms at_rest =
      spring_terms(model_.joints[0], Eigen::Vector2d(-0.4, 0.1), Eigen::Vector2d(0.0, 0.0), 0.0);
  const SpringTerms moving =
      spring_terms(model_.joints[0], Eigen::Vector2d(-0.4, 0.1), Eigen::Vector2d(-3.0, -3.0), 0.0);
  EXPECT_DOUBLE_EQ(std::max(moving.force - at_rest.force, moving.torque - at_rest.torque), 120.0);
  const double line_at_rest = of_element(0).force;
  std::get<LineSpring>(model_.elements[0].what).law.damping = 7.0;
  state_.bodies[1].v = Vec3(0.0, 2.0, 0.0);
  EXPECT_DOUBLE_EQ(of_element(0).force - line_at_rest, 14.0);
}

/// A driver that moves what an actuator pushes carries the difference of two large forces.
TEST_F(SpringTermsTest, ActuatorsTablesAndStopsAddUpWhatTheyPush) {
  ForceLaw& law = model_.joints[0].springs[0].law;
  law = {};
  const auto terms = [&](double x, double speed, double t) {
    return spring_terms(model_.joints[0], Eigen::Vector2d(x, x), Eigen::Vector2d(speed, speed), t).force;
  };
  law.actuator = ConstantSpeed{-3.0, 5.0};
  EXPECT_DOUBLE_EQ(terms(0.0, 0.0, 2.0), 7.0);
  law = {};
  law.spring_table = ForceTable({-1.0, 0.0, 1.0, 2.0}, {-4.0, 0.0, 4.0, 8.0});
  law.free = 0.25;
  EXPECT_NEAR(terms(0.75, 0.0, 0.0), 4.0 * 0.5 + 4.0 * (0.75 + 0.25), 1e-12);
  law = {};
  law.damper_table = ForceTable({-1.0, 0.0, 1.0, 2.0}, {-4.0, 0.0, 4.0, 8.0});
  EXPECT_NEAR(terms(0.0, -0.5, 0.0), 4.0, 1e-12);
  law = {};
  law.upper = SmoothStop{0.5, 100.0, 8.0, 0.1};
  law.lower = SmoothStop{-0.5, 1000.0, 0.0, 0.1};
  EXPECT_EQ(terms(0.4, 3.0, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(terms(0.7, -3.0, 0.0), 100.0 * (0.7 + 0.5) + 8.0 * 3.0);
  EXPECT_DOUBLE_EQ(terms(-0.7, 3.0, 0.0), 1000.0 * (0.7 + 0.5));
}

/// A turn spring's stop is pressed where its angle says so.
TEST_F(SpringTermsTest, StopsOfATurnSpringReadItsAngle) {
  ForceLaw& law = std::get<TurnSpring>(model_.elements[1].what).law;
  law = {};
  law.upper = SmoothStop{0.5, 100.0, 0.0, 0.1};
  EXPECT_EQ(of_element(1).torque, 0.0);
  law.upper->at = -0.5;
  EXPECT_DOUBLE_EQ(of_element(1).torque, 100.0 * (1.0 + 0.5));
}

}  // namespace
}  // namespace concord::compare
