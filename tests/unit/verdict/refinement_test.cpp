#include "compare/verdict/refinement.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

class RefinementTest : public ::testing::Test {
 protected:
  RefinementTest() {
    for (SolverSummary& solver : verdict_.solvers) solver.rank.joints.resize(1);
  }

  void record_all(Check check, double digits) {
    std::vector<Measured> measured(layout_.quantities().size());
    for (Measured& one : measured) {
      one.digits = one.unexplained_digits = digits;
      one.scale = 2.0;
      one.samples = 3;
    }
    record(layout_, measured, check, verdict_);
  }

  Model model_ = pendulum_model();
  QuantityLayout layout_{model_};
  Verdict verdict_;
};

TEST_F(RefinementTest, RowsAreWhatTheJointCarries) {
  make_rows(layout_, verdict_);
  ASSERT_EQ(verdict_.rows.size(), 10U);
  for (const QuantityRow& row : verdict_.rows) EXPECT_NE(row.quantity.component, 5);
}

TEST_F(RefinementTest, AllChecksMustBePassed) {
  make_rows(layout_, verdict_);
  record_all(Check::same_state, 13.0);
  record_all(Check::same_run, 7.5);
  record_all(Check::refined, 8.0);
  judge(verdict_);
  EXPECT_FALSE(verdict_.refined.passed);
  EXPECT_TRUE(verdict_.same_run.passed);
  EXPECT_EQ(verdict_.rows[0].judgement, Judgement::differ);
  record_all(Check::refined, 9.0);
  judge(verdict_);
  EXPECT_EQ(verdict_.rows[0].judgement, Judgement::agree);
  EXPECT_EQ(verdict_.rows[0].scale, 2.0);
  EXPECT_EQ(verdict_.judged, 10);
}

TEST_F(RefinementTest, TolerancesFallUntilRoundOff) {
  EXPECT_DOUBLE_EQ(refined_tolerance(1e-9), 1e-10);
  EXPECT_DOUBLE_EQ(refined_tolerance(1e-9, 50.0), 2e-11);
  EXPECT_DOUBLE_EQ(refined_tolerance(1e-13, 100.0), 1e-14);
  EXPECT_DOUBLE_EQ(refined_tolerance(3e-15), 3e-15);
}

TEST_F(RefinementTest, TheRequiredRiseIsThreeQuartersOfTheDigitsOfTheTolerance) {
  EXPECT_DOUBLE_EQ(required_rise(1e-9, 1e-10), 0.75);
  EXPECT_DOUBLE_EQ(required_rise(1e-9, 1e-11), 1.5);
  EXPECT_DOUBLE_EQ(required_rise(1e-9, 1e-13), 1.5);  // never more than what a hundred times ask
  EXPECT_DOUBLE_EQ(required_rise(1e-9, 1e-9), 0.75);  // a run that is no tighter shows nothing
  make_rows(layout_, verdict_);
  verdict_.run.rtol = 1e-11;
  set_refined_tolerance(verdict_, 1e-12);
  for (const QuantityRow& row : verdict_.rows) EXPECT_NEAR(row.required_rise, 0.75, 1e-12);
  record_all(Check::same_run, 7.3);
  record_all(Check::refined, 8.0);
  EXPECT_FALSE(meets_need(verdict_.rows[0], Check::refined));
  record_all(Check::refined, 8.1);
  EXPECT_TRUE(meets_need(verdict_.rows[0], Check::refined));
}

TEST_F(RefinementTest, TheDigitsThatAreMissingAskForTheTighteningThatGivesThem) {
  make_rows(layout_, verdict_);
  verdict_.need = default_needs(model_);
  record_all(Check::same_state, 14.0);
  const auto asked = [&](double digits) {
    record_all(Check::same_run, digits);
    return tightening_asked(verdict_);
  };
  EXPECT_DOUBLE_EQ(asked(9.0), 10.0);
  EXPECT_DOUBLE_EQ(asked(7.6), 10.0);
  EXPECT_NEAR(asked(7.3), std::pow(10.0, 1.6), 1e-9);
  EXPECT_DOUBLE_EQ(asked(3.0), 100.0);
  verdict_.rows[0].unique = false;  // nothing is asked for what is not judged
  record_all(Check::same_run, 9.0);
  verdict_.rows[0].detail[1].unexplained = 3.0;
  EXPECT_DOUBLE_EQ(tightening_asked(verdict_), 10.0);
  verdict_.motion = MotionAgreement{7.3, 0.1, "origin of bob"};
  EXPECT_NEAR(tightening_asked(verdict_), std::pow(10.0, 1.6), 1e-9);
}

TEST_F(RefinementTest, RefinedIsMetByTheRiseOrByItsNeed) {
  QuantityRow row;
  row.need = default_needs(model_);
  const auto set = [&](double same_run, double refined) {
    row.same_run = same_run;
    row.refined = refined;
    row.detail[static_cast<std::size_t>(Check::refined)].unexplained = refined;
  };
  set(3.0, 4.4);
  EXPECT_FALSE(meets_need(row, Check::refined));
  set(3.0, 4.5);
  EXPECT_TRUE(meets_need(row, Check::refined));
  set(8.4, 8.5);
  EXPECT_TRUE(meets_need(row, Check::refined));
}

TEST_F(RefinementTest, ACheckThatDidNotRunLeavesTheRowOpen) {
  make_rows(layout_, verdict_);
  record_all(Check::same_state, 13.0);
  judge(verdict_);
  EXPECT_EQ(verdict_.rows[0].judgement, Judgement::not_judged);
  EXPECT_FALSE(verdict_.same_run.passed);
  record_all(Check::same_state, 3.0);
  judge(verdict_);
  EXPECT_EQ(verdict_.rows[0].judgement, Judgement::differ);
}

/// Joints between the same bodies: what they carry together may differ where each by itself holds.
TEST_F(RefinementTest, ASumThatDiffersFailsTheSameState) {
  make_rows(layout_, verdict_);
  verdict_.need = default_needs(model_);
  record_all(Check::same_state, 14.0);
  PairSum sum;
  sum.samples = 3;
  sum.digits = sum.unexplained_digits = 15.0;
  verdict_.pair_sums = {sum};
  judge(verdict_);
  EXPECT_TRUE(verdict_.same_state.passed);
  EXPECT_EQ(verdict_.same_state.digits, 14.0);
  verdict_.pair_sums[0].digits = verdict_.pair_sums[0].unexplained_digits = 4.0;
  judge(verdict_);
  EXPECT_FALSE(verdict_.same_state.passed);
  EXPECT_EQ(verdict_.same_state.digits, 4.0);
}

TEST_F(RefinementTest, WhatIsNotUniqueAnywhereIsNotJudged) {
  make_rows(layout_, verdict_);
  std::vector<Measured> measured(layout_.quantities().size());
  for (Measured& one : measured) {
    one.digits = one.unexplained_digits = 13.0;
    one.scale = 2.0;
    one.samples = 3;
  }
  Measured& redundant = measured[layout_.row_of(verdict_.rows[1].quantity)];
  redundant.samples = 0;
  redundant.not_unique = 3;
  record(layout_, measured, Check::same_state, verdict_);
  judge(verdict_);
  EXPECT_EQ(verdict_.judged, 9);
  EXPECT_FALSE(verdict_.rows[1].unique);
  EXPECT_FALSE(is_judged(verdict_.rows[1]));
  EXPECT_FALSE(verdict_.rows[1].same_state.has_value());
  EXPECT_TRUE(verdict_.same_state.passed);
}

TEST_F(RefinementTest, RoundOffIsNoDifferenceAndIsTold) {
  make_rows(layout_, verdict_);
  std::vector<Measured> measured(layout_.quantities().size());
  for (Measured& one : measured) {
    one.digits = 9.7;
    one.unexplained_digits = 16.0;
    one.resolution = 2e-11;
    one.scale = 2.0;
    one.samples = 3;
  }
  record(layout_, measured, Check::same_state, verdict_);
  EXPECT_TRUE(meets_need(verdict_.rows[0], Check::same_state));
  EXPECT_TRUE(is_judged_by_resolution(verdict_.rows[0], Check::same_state));
  EXPECT_DOUBLE_EQ(*detail_of(verdict_.rows[0], Check::same_state).resolvable, 11.0);
  for (Measured& one : measured) one.unexplained_digits = 9.7;
  record(layout_, measured, Check::same_state, verdict_);
  EXPECT_FALSE(meets_need(verdict_.rows[0], Check::same_state));
  EXPECT_FALSE(is_judged_by_resolution(verdict_.rows[0], Check::same_state));
}

/// A need of 12 digits must not hide a difference that is a thousand resolutions and still tiny; a lowered need may,
/// and in a run resolution says nothing of integration errors.
TEST_F(RefinementTest, WhatIsBeyondAllRoundOffDiffersWhateverTheNeed) {
  QuantityRow row;
  row.need = default_needs(model_);
  row.same_state = row.same_run = 13.0;
  const auto set_ratio = [&](double ratio) {
    for (const Check check : {Check::same_state, Check::same_run}) {
      CheckDetail& detail = row.detail[static_cast<std::size_t>(check)];
      detail.unexplained = 13.0;
      detail.ratio = ratio;
    }
  };
  set_ratio(0.9 * kBeyondRoundOff);
  EXPECT_TRUE(meets_need(row, Check::same_state));
  set_ratio(1.1 * kBeyondRoundOff);
  EXPECT_FALSE(meets_need(row, Check::same_state));
  EXPECT_TRUE(meets_need(row, Check::same_run));
  EXPECT_LT(margin(row, Check::same_state), 0.0);  // a table that shows the nearest row shows this one
  row.need.because = "a soft stop: the same run needs fewer";
  EXPECT_FALSE(meets_need(row, Check::same_state));
  row.need.same_state_lowered = true;
  EXPECT_TRUE(meets_need(row, Check::same_state));
  EXPECT_GT(margin(row, Check::same_state), 0.0);
}

TEST_F(RefinementTest, WhereDoublePrecisionResolvesTooLittleNothingIsJudged) {
  make_rows(layout_, verdict_);
  std::vector<Measured> measured(layout_.quantities().size());
  for (Measured& one : measured) {
    one.samples = 0;
    one.too_coarse = 4;
    one.scale = 2.0;
  }
  record(layout_, measured, Check::same_state, verdict_);
  judge(verdict_);
  EXPECT_EQ(verdict_.judged, 0);
  EXPECT_TRUE(verdict_.rows[0].unique);
  EXPECT_FALSE(has_judged(verdict_));
}

TEST(Refinement, ForcesOnSpeedsDoNotStandForReactionsThatAreNotResolved) {
  const Model sprung = sprung_pendulum_model();
  const QuantityLayout layout(sprung);
  Verdict verdict;
  make_rows(layout, verdict);
  std::vector<Measured> measured(layout.quantities().size());
  for (std::size_t k = 0; k < measured.size(); ++k) {
    measured[k].scale = 2.0;
    measured[k].digits = measured[k].unexplained_digits = 15.0;
    (layout.quantities()[k].kind == Kind::tau ? measured[k].samples : measured[k].too_coarse) = 4;
  }
  record(layout, measured, Check::same_state, verdict);
  judge(verdict);
  EXPECT_FALSE(has_judged(verdict));
  for (QuantityRow& row : verdict.rows) row.unique = false;  // what nobody can judge may be left out
  EXPECT_TRUE(has_judged(verdict));
}

TEST_F(RefinementTest, AccelerationsAreJudgedAtTheSameStateOnly) {
  make_rows(layout_, verdict_);
  for (const Check check : kChecks) record_all(check, 13.0);
  for (const QuantityRow& row : verdict_.others) {
    EXPECT_EQ(row.same_run.has_value(), row.quantity.kind != Kind::acceleration);
  }
  judge(verdict_);
  EXPECT_TRUE(verdict_.same_run.passed);
  EXPECT_EQ(*verdict_.same_run.digits, 13.0);
}

}  // namespace
}  // namespace concord::compare
