#include <gtest/gtest.h>

#include <numbers>

#include "common/joints/cylindrical.h"
#include "common/joints/screw.h"
#include "common/joints/spherical.h"
#include "common/joints/universal.h"
#include "compare/states/branch.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

class WholeTurnsTest : public ::testing::Test {
 protected:
  [[nodiscard]] bool change_nothing(int word = 0) const { return whole_turns_change_nothing(model_, 0, word, 0); }
  ForceLaw& add_spring(int word = 0) {
    JointSpring& spring = model_.joints[0].springs.emplace_back();
    spring.word = word;
    return spring.law;
  }

  Model model_ = pendulum_model();
};

TEST_F(WholeTurnsTest, ChangeNothingOfAnAngleAboutAnAxis) {
  EXPECT_TRUE(change_nothing());
  model_.joints[0].type = &joints::universal;
  EXPECT_TRUE(change_nothing(0));
  EXPECT_TRUE(change_nothing(1));
}

TEST_F(WholeTurnsTest, ChangeThePlaceOnAThreadAndAreNoneOfSlidesAndBalls) {
  model_.joints[0].type = &joints::screw;
  EXPECT_FALSE(change_nothing());
  model_.joints[0].type = &joints::spherical;
  EXPECT_FALSE(change_nothing());
  model_.joints[0].type = &joints::cylindrical;
  const bool slides_first = joints::is_length(joints::cylindrical.permits[0], 0);
  EXPECT_FALSE(change_nothing(slides_first ? 0 : 1));
  EXPECT_TRUE(change_nothing(slides_first ? 1 : 0));
}

TEST_F(WholeTurnsTest, AreReadBySpringsTablesAndStops) {
  add_spring().stiffness = 2.0;
  EXPECT_FALSE(change_nothing());
  model_.joints[0].springs.clear();
  add_spring().spring_table.emplace(std::vector<double>{-1, 0, 1, 2}, std::vector<double>{-3, 0, 3, 6});
  EXPECT_FALSE(change_nothing());
  model_.joints[0].springs.clear();
  add_spring().lower = SmoothStop{-0.5, 100.0, 0.0, 0.1};
  EXPECT_FALSE(change_nothing());
  model_.joints[0].springs.clear();
  add_spring().upper = SmoothStop{0.5, 100.0, 0.0, 0.1};
  EXPECT_FALSE(change_nothing());
}

TEST_F(WholeTurnsTest, AreNotReadByDampersMotorsAndWhatActsOnOtherCoordinates) {
  ForceLaw& law = add_spring();
  law.damping = 0.3;
  law.preload = 4.0;
  law.actuator = ConstantSpeed{1.0, 0.0};
  EXPECT_TRUE(change_nothing());
  model_.joints[0].type = &joints::universal;
  add_spring(1).stiffness = 2.0;
  EXPECT_TRUE(change_nothing(0));
  EXPECT_FALSE(change_nothing(1));
}

TEST_F(WholeTurnsTest, AreReadByDriversAndCouplings) {
  model_.joints[0].drivers.push_back({0, ConstantSpeed{1.0, 0.0}});
  EXPECT_FALSE(change_nothing());
  model_.joints[0].drivers.clear();
  model_.joints.push_back(model_.joints[0]);
  model_.couplings.push_back({"gear", {{0, 0, 0, 1.0}, {1, 0, 0, -2.0}}, 0.0, {}});
  EXPECT_FALSE(change_nothing());
  EXPECT_FALSE(whole_turns_change_nothing(model_, 1, 0, 0));
}

TEST_F(WholeTurnsTest, MoveAnAngleNextToAnother) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  EXPECT_EQ(with_turns_of(0.3, 0.7), 0.7);
  EXPECT_DOUBLE_EQ(with_turns_of(3.0 * kTurn, -0.2), 3.0 * kTurn - 0.2);
  EXPECT_DOUBLE_EQ(with_turns_of(-3.0, 3.0), 3.0 - kTurn);
}

}  // namespace
}  // namespace concord::compare
