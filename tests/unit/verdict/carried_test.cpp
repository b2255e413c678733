#include "compare/verdict/carried.h"

#include <gtest/gtest.h>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

/// The pendulum, rigid, all checks passed: 12, 7 and 8.5 digits are needed.
class CarriedTest : public ::testing::Test {
 protected:
  CarriedTest() {
    verdict_.need = default_needs(model_);
    verdict_.run.until = 10.0;
    make_rows(layout_, verdict_);
    record_all(Check::same_state, 13.0);
    record_all(Check::same_run, 7.5);
    record_all(Check::refined, 9.0);
    conclude();
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

  void conclude() {
    judge(verdict_);
    verdict_.outcome = Outcome::agree;
  }

  void set(QuantityRow& row, Check check, double digits, double unexplained) {
    (check == Check::same_state ? row.same_state : check == Check::same_run ? row.same_run : row.refined) = digits;
    row.detail[static_cast<std::size_t>(check)].unexplained = unexplained;
  }

  Model model_ = pendulum_model();
  QuantityLayout layout_{model_};
  Verdict verdict_;
};

TEST_F(CarriedTest, WhatPassesPlainlyHasNothingToSay) {
  for (const Check check : kChecks) {
    ASSERT_TRUE(summary_of(verdict_, check).passed);
    EXPECT_EQ(passed_with_less(verdict_, check), "");
  }
  EXPECT_EQ(judged_instead(verdict_), "");
}

TEST_F(CarriedTest, RoundOffThatHidesMissingDigitsIsSaid) {
  set(verdict_.rows[2], Check::same_run, 3.6, 16.0);
  set(verdict_.rows[7], Check::same_run, 6.9, 8.0);
  set(verdict_.rows[1], Check::same_state, 11.9, 12.5);
  conclude();
  ASSERT_TRUE(verdict_.same_run.passed);
  EXPECT_DOUBLE_EQ(*verdict_.same_run.digits, 3.6);
  EXPECT_EQ(passed_with_less(verdict_, Check::same_run), "2 of 10 below 7 digits, within round-off");
  EXPECT_EQ(passed_with_less(verdict_, Check::same_state), "1 of 10 below 12 digits, within round-off");
}

TEST_F(CarriedTest, SoAreDigitsThatRiseInPlaceOfTheNeed) {
  set(verdict_.rows[4], Check::refined, 8.3, 8.3);
  set(verdict_.rows[4], Check::same_run, 6.7, 7.2);
  conclude();
  ASSERT_TRUE(verdict_.refined.passed);
  EXPECT_EQ(passed_with_less(verdict_, Check::refined), "1 of 10 below 8.5 digits, risen by 1.5 digits");
}

TEST_F(CarriedTest, SoIsANeedThatTheModelLowers) {
  QuantityRow& row = verdict_.rows[3];
  row.need.same_state = 5.0;
  row.need.same_state_lowered = true;
  row.need.because = "tested elsewhere";
  set(row, Check::same_state, 5.2, 5.2);
  conclude();
  ASSERT_TRUE(verdict_.same_state.passed);
  EXPECT_EQ(passed_with_less(verdict_, Check::same_state), "1 of 10 below 12 digits, the model lowers the need");
  EXPECT_EQ(passed_with_less(verdict_, Check::same_run), "") << "its digits are enough for any model";
}

TEST_F(CarriedTest, SoAreRowsThatACheckLeavesOut) {
  QuantityRow& row = verdict_.rows[0];
  row.same_run.reset();
  row.detail[static_cast<std::size_t>(Check::same_run)].samples = 0;
  row.detail[static_cast<std::size_t>(Check::same_run)].too_coarse = 3;
  set(verdict_.rows[5], Check::same_run, 2.0, 9.0);
  conclude();
  ASSERT_EQ(row.judgement, Judgement::agree);
  EXPECT_EQ(passed_with_less(verdict_, Check::same_run),
            "1 of 10 below 7 digits, within round-off; 1 of 10 not judged there");
}

TEST_F(CarriedTest, SoIsAHorizon) {
  verdict_.same_run.horizon = 3.25;
  EXPECT_EQ(passed_with_less(verdict_, Check::same_run), "up to t = 3.25 s of 10 s");
}

TEST_F(CarriedTest, ACheckThatIsNotPassedNeedsNoExcuse) {
  set(verdict_.rows[2], Check::same_run, 3.6, 16.0);
  set(verdict_.rows[3], Check::same_run, 3.6, 3.6);
  conclude();
  EXPECT_EQ(passed_with_less(verdict_, Check::same_run), "");
}

TEST_F(CarriedTest, WhereNoComponentIsUniqueTheLineSaysWhatIsJudged) {
  for (auto* rows : {&verdict_.rows, &verdict_.others}) {
    for (QuantityRow& row : *rows) {
      row.unique = row.quantity.kind == Kind::body_sum;
      row.judgement = Judgement::not_judged;
    }
  }
  PairSum sum;
  sum.samples = 3;
  sum.digits = 11.0;
  sum.unexplained_digits = 14.0;
  PairSum open;
  open.samples = 0;
  verdict_.pair_sums = {sum, open};
  for (CheckSummary* check : {&verdict_.same_state, &verdict_.same_run, &verdict_.refined}) *check = CheckSummary();
  conclude();
  ASSERT_TRUE(verdict_.same_state.passed);
  EXPECT_EQ(judged_instead(verdict_),
            "no single component is unique; judged instead: 1 total of joints that share what they carry");
  verdict_.pair_sums.push_back(sum);
  EXPECT_EQ(judged_instead(verdict_),
            "no single component is unique; judged instead: 2 totals of joints that share what they carry");
  EXPECT_EQ(passed_with_less(verdict_, Check::same_state), "2 of 3 below 12 digits, within round-off");
  EXPECT_EQ(passed_with_less(verdict_, Check::same_run), "by the sums on bodies alone");
  verdict_.outcome = Outcome::failed;
  EXPECT_EQ(judged_instead(verdict_), "");
}

}  // namespace
}  // namespace concord::compare
