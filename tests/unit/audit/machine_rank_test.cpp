#include "compare/audit/machine_rank.h"

#include <gtest/gtest.h>

#include "common/joints/spherical.h"
#include "compare/audit/places.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

/// A tilted pendulum; with a ball on the axis of its hinge beside it, three of its constraints say nothing new.
class MachineRankTest : public ::testing::Test {
 protected:
  MachineConstraints constraints() const { return {model_, state_}; }

  /// A ball on the axis of the hinge, off its point.
  void add_ball() {
    Joint ball = model_.joints[0];
    ball.name = "ball";
    ball.type = &joints::spherical;
    for (Attachment& side : ball.sides) side.point_L += side.C.col(2) * 0.2;
    ball.sides[0].C = ball.sides[0].C * rotation_about(Vec3(2, 1, 2) / 3.0, 0.7);
    ball.start = {{}};
    model_.joints.push_back(ball);
    state_.q.emplace_back(Vec4::Unit(0));
    state_.u.emplace_back(Vec3::Zero());
  }

  Model model_ = pendulum_model();
  State state_ = FakePendulum(model_, "pendulum").assemble();
};

TEST_F(MachineRankTest, AHingeForbidsFiveDirections) {
  const MachineConstraints hinge = constraints();
  EXPECT_TRUE(hinge.is_sure());
  EXPECT_EQ(hinge.report().constraints, 5);
  EXPECT_EQ(hinge.report().rank, 5);
  EXPECT_EQ(hinge.report().degrees_of_freedom, 1);
  EXPECT_TRUE(hinge.in_self_stress().empty());
  for (const auto& side : hinge.report().joints[0].unique) {
    for (const bool is_unique : side) EXPECT_TRUE(is_unique);
  }
}

TEST_F(MachineRankTest, ADriverTakesTheLastFreedom) {
  model_.joints[0].drivers = {{0, Polynomial{{0.7, 3.1}}}};
  const MachineConstraints driven = constraints();
  EXPECT_EQ(driven.report().constraints, 6);
  EXPECT_EQ(driven.report().rank, 6);
  EXPECT_EQ(driven.report().degrees_of_freedom, 0);
  EXPECT_TRUE(driven.report().joints[0].unique_tau[0]);
}

TEST_F(MachineRankTest, ABallOnTheAxisSaysNothingNew) {
  add_ball();
  const MachineConstraints redundant = constraints();
  EXPECT_TRUE(redundant.is_sure());
  EXPECT_EQ(redundant.report().constraints, 8);
  EXPECT_EQ(redundant.report().rank, 5);
  EXPECT_EQ(redundant.report().degrees_of_freedom, 1);
  EXPECT_EQ(redundant.in_self_stress(), (std::vector<std::string>{"joint A", "joint ball"}));
  for (int side = 0; side < 2; ++side) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_FALSE(redundant.report().joints[0].unique[side][c]) << c;
      EXPECT_FALSE(redundant.report().joints[1].unique[side][c]) << c;
      // Forces on the ball across the axis turn the hinge, and none of them turns the ball.
      EXPECT_EQ(redundant.report().joints[0].unique[side][3 + c], c == 2) << c;
      EXPECT_TRUE(redundant.report().joints[1].unique[side][3 + c]) << c;
    }
  }
}

// Forces alone: every self-stress leaves the bob in balance, in the axes of both frames, and passes each joint whole.
TEST_F(MachineRankTest, SelfStressesLeaveEveryBodyInBalance) {
  EXPECT_TRUE(constraints().self_stresses(state_).empty());
  add_ball();
  model_.joints[0].drivers = {{0, Polynomial{{0.7, 3.1}}}};
  const std::vector<Evaluation> all = constraints().self_stresses(state_);
  ASSERT_EQ(all.size(), 3U);
  for (const Evaluation& one : all) {
    Vec6 on_bob = Vec6::Zero();
    double largest = 0.0;
    for (std::size_t k = 0; k < 2; ++k) {
      const Joint& joint = model_.joints[k];
      const SideWrench& child = one.joints[k].total_on(Side::child);
      const SideWrench& parent = one.joints[k].total_on(Side::parent);
      const PlacedFrame at = place(joint.on(Side::child), state_.bodies[1]);
      on_bob.head<3>() += child.in_global.force;
      on_bob.tail<3>() += child.in_global.torque + at.lever.cross(child.in_global.force);
      largest = std::max(largest, child.in_C.vector().norm());
      EXPECT_LT((at.A_joint * child.in_C.force - child.in_global.force).norm(), 1e-14);
      EXPECT_LT((child.in_global.vector() + parent.in_global.vector()).norm(), 1e-12) << "both points are one";
    }
    EXPECT_LT(on_bob.norm(), 1e-12);
    EXPECT_GT(largest, 0.1);
  }
}

/// Two drivers on one coordinate, as two joints between the same bodies allow: their forces hold each other alone.
TEST_F(MachineRankTest, TwoDriversOfOneTurnHoldEachOther) {
  model_.joints[0].drivers = {{0, Polynomial{{0.7, 3.1}}}};
  model_.joints.push_back(model_.joints[0]);
  state_.q.push_back(state_.q[0]);
  state_.u.push_back(state_.u[0]);
  const RankReport report = constraints().report();
  EXPECT_EQ(report.constraints, 12);
  EXPECT_EQ(report.rank, 6);
  EXPECT_FALSE(report.joints[0].unique_tau[0]);
  EXPECT_FALSE(report.joints[0].unique_total[1][5]);
}

TEST_F(MachineRankTest, VelocitiesAreHeldAgainstWhatIsPermitted) {
  const MachineConstraints hinge = constraints();
  MatX turn = FakePendulum(model_, "pendulum").tangent(state_);
  const SpanOfVelocities right = hinge.hold_against(turn);
  EXPECT_TRUE(right.holds_all);
  EXPECT_TRUE(right.holds_nothing_else);

  const SpanOfVelocities none = hinge.hold_against(MatX(6, 0));
  EXPECT_FALSE(none.holds_all);
  EXPECT_TRUE(none.holds_nothing_else);

  MatX more(6, 2);
  more << turn, VecX::Unit(6, 1);
  const SpanOfVelocities too_many = hinge.hold_against(more);
  EXPECT_TRUE(too_many.holds_all);
  EXPECT_FALSE(too_many.holds_nothing_else);

  turn(4) += 0.01;
  const SpanOfVelocities tilted = hinge.hold_against(turn);
  EXPECT_FALSE(tilted.holds_all);
  EXPECT_FALSE(tilted.holds_nothing_else);
  EXPECT_EQ(tilted.worst, "joint A");
}

TEST_F(MachineRankTest, AnOpenStateIsNamed) {
  EXPECT_EQ(place_left_open(model_, state_), "");
  state_.bodies[1].v += Vec3(1e-4, 0, 0);
  EXPECT_EQ(place_left_open(model_, state_), "joint A");
}

}  // namespace
}  // namespace concord::compare
