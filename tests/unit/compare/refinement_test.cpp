#include "compare/refinement.h"

#include <gtest/gtest.h>

#include "fake_pendulum.h"

namespace concord::compare {
namespace {

class RefinementTest : public ::testing::Test {
 protected:
  RefinementTest() {
    for (SolverSummary& solver : verdict_.solvers) solver.rank.joints.resize(1);
  }

  void record_all(Rung rung, double digits) {
    std::vector<Measured> measured(layout_.quantities().size());
    for (Measured& one : measured) {
      one.digits = digits;
      one.scale = 2.0;
    }
    record(layout_, measured, rung, verdict_);
  }

  Model model_ = pendulum_model();
  Layout layout_{model_};
  Verdict verdict_;
};

TEST_F(RefinementTest, RowsAreWhatTheJointCarries) {
  make_rows(layout_, verdict_);
  ASSERT_EQ(verdict_.rows.size(), 10U);
  for (const Row& row : verdict_.rows) EXPECT_NE(row.quantity.component, 5);
}

TEST_F(RefinementTest, AllRungsMustBeClimbed) {
  make_rows(layout_, verdict_);
  record_all(Rung::same_state, 13.0);
  record_all(Rung::same_run, 7.5);
  record_all(Rung::refined, 8.0);
  judge(verdict_);
  EXPECT_FALSE(verdict_.refined.climbed);
  EXPECT_TRUE(verdict_.same_run.climbed);
  EXPECT_EQ(verdict_.rows[0].judgement, Judgement::differ);
  record_all(Rung::refined, 9.0);
  judge(verdict_);
  EXPECT_EQ(verdict_.rows[0].judgement, Judgement::agree);
  EXPECT_EQ(verdict_.rows[0].scale, 2.0);
  EXPECT_EQ(verdict_.judged, 10);
}

TEST_F(RefinementTest, TolerancesFallAHundredTimesUntilRoundOff) {
  EXPECT_DOUBLE_EQ(refined_tolerance(1e-9), 1e-11);
  EXPECT_DOUBLE_EQ(refined_tolerance(1e-13), 1e-14);
  EXPECT_DOUBLE_EQ(refined_tolerance(3e-15), 3e-15);
}

TEST_F(RefinementTest, RefinedIsMetByTheRiseOrByItsNeed) {
  Row row;
  row.need = default_needs(model_);
  row.same_run = 3.0;
  row.refined = 4.4;
  EXPECT_FALSE(climbs(row, Rung::refined));
  row.refined = 4.5;
  EXPECT_TRUE(climbs(row, Rung::refined));
  row.same_run = 8.4;
  row.refined = 8.5;
  EXPECT_TRUE(climbs(row, Rung::refined));
}

TEST_F(RefinementTest, ARungThatDidNotRunLeavesTheRowOpen) {
  make_rows(layout_, verdict_);
  record_all(Rung::same_state, 13.0);
  judge(verdict_);
  EXPECT_EQ(verdict_.rows[0].judgement, Judgement::not_judged);
  EXPECT_FALSE(verdict_.same_run.climbed);
  record_all(Rung::same_state, 3.0);
  judge(verdict_);
  EXPECT_EQ(verdict_.rows[0].judgement, Judgement::differ);
}

TEST_F(RefinementTest, EitherSolverMakesAComponentNotUnique) {
  verdict_.solvers[1].rank.joints[0].unique[index(Side::child)][1] = false;
  verdict_.solvers[0].rank.joints[0].unique_total[index(Side::child)][1] = false;
  make_rows(layout_, verdict_);
  record_all(Rung::same_state, 1.0);
  judge(verdict_);
  EXPECT_EQ(verdict_.judged, 9);
  for (const std::vector<Row>& rows : {verdict_.rows, verdict_.others}) {
    for (const Row& row : rows) {
      const Quantity& quantity = row.quantity;
      const bool on_child = quantity.side == Side::child;
      const bool is_wrench = quantity.kind == Kind::reaction || quantity.kind == Kind::total;
      const bool expected = !(on_child && ((is_wrench && quantity.component == 1) ||
                                           (quantity.kind == Kind::reaction_global && quantity.component < 3)));
      EXPECT_EQ(row.unique, expected);
    }
  }
}

TEST_F(RefinementTest, AccelerationsAreJudgedAtTheSameStateOnly) {
  make_rows(layout_, verdict_);
  for (const Rung rung : kRungs) record_all(rung, 13.0);
  for (const Row& row : verdict_.others) {
    EXPECT_EQ(row.same_run.has_value(), row.quantity.kind != Kind::acceleration);
  }
  judge(verdict_);
  EXPECT_TRUE(verdict_.same_run.climbed);
  EXPECT_EQ(*verdict_.same_run.digits, 13.0);
}

}  // namespace
}  // namespace concord::compare
