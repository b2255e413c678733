#include "compare/states/singular_pose.h"

#include <gtest/gtest.h>

#include "tests/unit/four_states.h"

namespace concord::compare {
namespace {

class SingularPoseTest : public FourStatesTest {
 protected:
  [[nodiscard]] SingularPoses poses() const { return {model_, states_, reports_}; }

  /// A drawn state whose rank counts a row by the root of round-off.
  void draw_beside_singular() {
    reports_[2][0].rank = 6;
    reports_[2][0].smallest_kept = 1e-8;
    states_[2].row = -1;
    for (SharedState& shared : states_) shared.state.bodies.resize(model_.bodies.size());
  }
};

TEST_F(SingularPoseTest, AStateOfLowerRankThanOthersIsOne) {
  FakePendulum cartesian(model_, "cartesian");
  FakePendulum relative(model_, "relative");
  const std::array<Solver*, 2> solvers{&cartesian, &relative};
  for (const std::string& why : poses().reasons(solvers, states_, reports_)) EXPECT_EQ(why, "");
  reports_[2][1].rank = 4;
  EXPECT_EQ(poses().general_rank(1), 5);
  EXPECT_TRUE(poses().is_singular(reports_[2][1], 1));
  EXPECT_FALSE(poses().is_singular(reports_[2][0], 0));
  const std::vector<std::string> why = poses().reasons(solvers, states_, reports_);
  ASSERT_EQ(why.size(), 4U);
  for (const std::size_t k : {0U, 1U, 3U}) EXPECT_EQ(why[k], "");
  EXPECT_EQ(why[2], "relative: at t = 0.2 s the pose is singular: the constraints have rank 4 there, 5 in other poses");
}

TEST_F(SingularPoseTest, ARankByTheRootOfRoundOffIsNotTheGeneralOneOfAMachineThatMoves) {
  draw_beside_singular();
  EXPECT_EQ(poses().general_rank(0), 6) << "locked";
  EXPECT_EQ(poses().general_rank(1), 5);
  EXPECT_EQ(poses().leave_out_beside(states_, reports_), 0);
  states_[1].state.bodies[1].r = {0.3, 0.1, 0.2};
  EXPECT_EQ(poses().general_rank(0), 5);
  EXPECT_EQ(poses().leave_out_beside(states_, reports_), 1);
  ASSERT_EQ(states_.size(), 3U);
  ASSERT_EQ(reports_.size(), 3U);
  EXPECT_EQ(states_[2].row, 3);
  for (const auto& both : reports_) EXPECT_EQ(both[0].rank, 5);
}

TEST_F(SingularPoseTest, WhatMovesBesideALockedLoopSaysNothingOfIt) {
  model_.bodies.push_back(model_.bodies[1]);
  for (auto& both : reports_) both[0].joints[0].unique[index(Side::child)][1] = false;
  draw_beside_singular();
  states_[1].state.bodies[2].r = {0.3, 0.1, 0.2};
  EXPECT_EQ(poses().general_rank(0), 6);
  states_[1].state.bodies[1].r = {0.0, 0.1, 0.0};
  EXPECT_EQ(poses().general_rank(0), 5);
}

TEST_F(SingularPoseTest, ClosingKnowsAStateByTheSquareOfTheSmallestSingularValue) {
  const auto known = [&](double smallest_kept) {
    report_.smallest_kept = smallest_kept;
    return known_from_closing(report_);
  };
  EXPECT_LT(known(0.1), 1e-12);
  EXPECT_NEAR(known(1e-4) / known(1e-3), 100.0, 1e-9);
  EXPECT_EQ(known(1e-7), 1e-4) << "farther away is another state";
  EXPECT_EQ(known(0.0), 0.0) << "a tree closes exactly";
}

}  // namespace
}  // namespace concord::compare
