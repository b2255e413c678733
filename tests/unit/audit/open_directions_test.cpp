#include "compare/audit/open_directions.h"

#include <gtest/gtest.h>

#include "tests/unit/two_balls.h"

namespace concord::compare {
namespace {

class OpenDirectionsTest : public ::testing::Test {
 protected:
  OpenDirectionsTest() {
    const Model pendulum = pendulum_model();
    state_ = on_two_balls(FakePendulum(pendulum, "pendulum").assemble());
  }

  Model model_ = two_balls_model();
  State state_;
};

TEST_F(OpenDirectionsTest, TheThrustOfTwoBallsIsOpenAlongTheirLineAlone) {
  const MachineConstraints constraints(model_, state_);
  ASSERT_EQ(constraints.self_stresses().cols(), 1);
  for (int joint = 0; joint < 2; ++joint) {
    for (const Side side : kSides) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_FALSE(constraints.report().joints[static_cast<std::size_t>(joint)].unique[index(side)][c])
            << "no axis of the frame lies across the line";
      }
      const OpenDirections force = open_directions(constraints, joint, side, 0);
      ASSERT_EQ(force.directions.cols(), 1);
      EXPECT_TRUE(force.is_clear);
      EXPECT_EQ(force.carried, 3);
      const Vec3 axis = joint_frame_on(model_, state_, joint, side).transpose() * axis_of_balls();
      EXPECT_NEAR(force.directions.col(0).cross(axis).norm(), 0.0, 1e-12);
      EXPECT_NEAR((force.projector() * axis).norm(), 0.0, 1e-12);
      EXPECT_NEAR((force.projector() * axis.unitOrthogonal() - axis.unitOrthogonal()).norm(), 0.0, 1e-12);
      const OpenDirections torque = open_directions(constraints, joint, side, 1);
      EXPECT_EQ(torque.directions.cols(), 0);
      EXPECT_EQ(torque.carried, 0);
    }
  }
}

TEST_F(OpenDirectionsTest, NothingIsOpenWithoutRedundantConstraints) {
  model_.joints.pop_back();
  const OpenDirections force = open_directions({model_, state_}, 0, Side::child, 0);
  EXPECT_EQ(force.directions.cols(), 0);
  EXPECT_TRUE(force.is_clear);
  EXPECT_TRUE(force.projector().isIdentity());
}

/// Balls nearly in one point: where the line between them points, double precision does not say.
TEST_F(OpenDirectionsTest, ADirectionThatRoundOffTurnsIsNotClear) {
  for (Attachment& side : model_.joints[1].sides) side.point_L = model_.joints[0].on(Side::child).point_L;
  model_.joints[1].sides[0].point_L = model_.joints[0].on(Side::parent).point_L;
  const Vec3 beside = 1e-7 * axis_of_balls();
  model_.joints[1].sides[0].point_L += beside;
  model_.joints[1].sides[1].point_L += rotation_of(state_.bodies[1].p).transpose() * beside;
  const MachineConstraints constraints(model_, state_);
  EXPECT_GT(open_directions(constraints, 0, Side::child, 0).doubt, 1e-10);
  EXPECT_FALSE(open_directions(constraints, 0, Side::child, 0).is_clear);
}

}  // namespace
}  // namespace concord::compare
