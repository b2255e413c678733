#include "compare/resolution/uniqueness.h"

#include <gtest/gtest.h>

#include "tests/unit/four_states.h"

namespace concord::compare {
namespace {

class UniquenessTest : public FourStatesTest {
 protected:
  [[nodiscard]] bool is_judged(const Quantity& quantity, int state) const {
    return judged_states(layout_, reports_)(layout_.row_of(quantity), state);
  }

  /// Flags and doubt on the child's force along y.
  static void set(RankReport& report, bool unique, bool decided) {
    report.joints[0].unique[index(Side::child)][1] = unique;
    report.decided.resize(1);
    report.decided[0].unique[index(Side::child)][1] = decided;
  }

  QuantityLayout layout_{model_};
  const Quantity force_{Kind::reaction, 0, Side::child, 1};
};

TEST_F(UniquenessTest, EachStateIsDecidedByItself) {
  set(reports_[2][0], false, true);
  set(reports_[2][1], false, true);
  EXPECT_TRUE(is_judged(force_, 1));
  EXPECT_FALSE(is_judged(force_, 2));
  EXPECT_FALSE(is_judged({Kind::reaction_global, 0, Side::child, 0}, 2)) << "global components mix all three";
  EXPECT_TRUE(is_judged({Kind::reaction_global, 0, Side::child, 4}, 2)) << "torques are unique";
  EXPECT_TRUE(is_judged({Kind::total, 0, Side::child, 1}, 2));
  EXPECT_TRUE(is_judged({Kind::body_sum, 1, Side::child, 1}, 2));
  EXPECT_TRUE(compare_uniqueness(layout_, states_, reports_).empty());
}

TEST_F(UniquenessTest, EitherSolverKeepsAComponentFromBeingJudgedAndADisagreementIsTold) {
  for (const int state : {1, 3}) set(reports_[state][1], false, true);
  EXPECT_FALSE(is_judged(force_, 1));
  const std::vector<Finding> findings = compare_uniqueness(layout_, states_, reports_);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].what,
            "rank: joint A on bob, F_y is unique for cartesian, not unique for relative, in 2 of 4 states, first at "
            "t = 0.1 s");
}

TEST_F(UniquenessTest, WhatIsUndecidedIsNotJudgedAndIsNoDifference) {
  set(reports_[0][0], true, false);
  set(reports_[0][1], false, true);
  EXPECT_FALSE(is_judged(force_, 0));
  EXPECT_TRUE(compare_uniqueness(layout_, states_, reports_).empty());
}

TEST_F(UniquenessTest, TotalsDriversAndCountsAreComparedToo) {
  for (auto& both : reports_) both[1].joints[0].unique_total[index(Side::parent)][3] = false;
  reports_[3][1].rank = 4;
  reports_[3][1].degrees_of_freedom = 2;
  const std::vector<Finding> findings = compare_uniqueness(layout_, states_, reports_);
  ASSERT_EQ(findings.size(), 3U);
  EXPECT_EQ(findings[0].what,
            "rank: cartesian finds 0 redundant constraints, relative 1, in 1 of 4 states, first at t = 0.3 s");
  EXPECT_EQ(findings[1].what,
            "rank: cartesian finds 1 degrees of freedom, relative 2, in 1 of 4 states, first at t = 0.3 s");
  EXPECT_EQ(findings[2].what,
            "rank: joint A on ground (total wrench), T_x is unique for cartesian, not unique for relative, in 4 of 4 "
            "states, first at t = 0 s");
}

TEST_F(UniquenessTest, AlongTheHingeNothingIsCarriedAndNothingCompared) {
  for (auto& both : reports_) both[1].joints[0].unique[index(Side::child)][5] = false;
  EXPECT_TRUE(compare_uniqueness(layout_, states_, reports_).empty());
}

TEST_F(UniquenessTest, ASampleIsJudgedWhereAllItsStatesAre) {
  set(reports_[1][0], false, true);
  states_[1].row = 0;
  states_[2].row = -1;
  const Mask of_run = mask_of_run(judged_states(layout_, reports_), states_, 4);
  const int row = layout_.row_of(force_);
  EXPECT_FALSE(of_run(row, 0));
  EXPECT_FALSE(of_run(row, 1)) << "no state was taken from it";
  EXPECT_TRUE(of_run(row, 3));
}

/// The axes of a machine line up in one pose, and the solvers find a component unique there alone.
TEST_F(UniquenessTest, UniqueAtAnIsolatedStateIsNotUniqueInTheRun) {
  for (const int state : {0, 1, 3}) {
    for (RankReport& report : reports_[state]) set(report, false, true);
  }
  const Quantity beside{Kind::reaction, 0, Side::child, 0};
  for (RankReport& report : reports_[0]) report.joints[0].unique[index(Side::child)][0] = false;
  Mask unique = judged_states(layout_, reports_);
  ASSERT_TRUE(unique(layout_.row_of(force_), 2));
  leave_out_isolated(layout_, states_, reports_, unique);
  EXPECT_FALSE(unique.row(layout_.row_of(force_)).any());
  EXPECT_EQ(unique.row(layout_.row_of(beside)).count(), 3) << "open at one state alone";
}

TEST_F(UniquenessTest, WhatIsUniqueIsCountedInTheRunAndDoubtIsNotOpen) {
  states_.push_back(states_[0]);  // perturbed states, in which the component is open
  states_.push_back(states_[0]);
  for (int k = 4; k < 6; ++k) {
    states_[static_cast<std::size_t>(k)].row = -1;
    reports_.push_back({report_, report_});
    for (RankReport& report : reports_.back()) set(report, false, true);
  }
  set(reports_[0][0], false, false);
  set(reports_[1][0], true, false);
  set(reports_[2][1], false, true);
  Mask unique = judged_states(layout_, reports_);
  leave_out_isolated(layout_, states_, reports_, unique);
  EXPECT_EQ(unique.row(layout_.row_of(force_)).count(), 1);
}

TEST_F(UniquenessTest, StatesInWhichASolverCannotSayAreDroppedAndCounted) {
  FakePendulum sound(model_, "cartesian");
  FakePendulum stops(model_, "relative");
  stops.spoil_rank = [calls = 0](RankReport&) mutable {
    if (calls++ == 1) throw SingularPose("relative: singular at t = 0.1 s");
  };
  int dropped = 0;
  std::string why;
  const RankReports reports = report_ranks({&sound, &stops}, states_, dropped, why);
  EXPECT_EQ(reports.size(), 3U);
  EXPECT_EQ(states_.size(), 3U);
  EXPECT_EQ(dropped, 1);
  EXPECT_EQ(why, "relative: singular at t = 0.1 s");
  EXPECT_EQ(states_[1].row, 2);
}

}  // namespace
}  // namespace concord::compare
