#include "compare/report/table.h"

#include <gmock/gmock.h>

#include <sstream>

#include "compare/report/report_json.h"
#include "compare/report/text_table.h"
#include "compare/verdict/refinement.h"
#include "compare/verdict/verify.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(FormatTableTest, AlignsColumnsUnderARule) {
  EXPECT_EQ(format_table({{"a", "digits"}, {"long name", "7.1"}}, {false, true}),
            "| a         | digits |\n"
            "|-----------|-------:|\n"
            "| long name |    7.1 |\n");
}

class TableTest : public ::testing::Test {
 protected:
  std::string text(bool all_rows) {
    return format_verdict(model_, verify(model_, cartesian_, relative_, {}), all_rows);
  }

  /// Lines of the reaction table below its rule.
  static std::vector<std::string> rows_of(const std::string& text) {
    std::vector<std::string> rows;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("| pendulum")) rows.push_back(line);
    }
    return rows;
  }

  Model model_ = pendulum_model();
  FakePendulum cartesian_{model_, "cartesian"};
  FakePendulum relative_{model_, "relative"};
};

TEST_F(TableTest, CompactHasOneRowForEachJointAndSide) {
  const std::string table = text(false);
  EXPECT_THAT(table, HasSubstr("| case     | joint | on     | component |"));
  EXPECT_THAT(table, HasSubstr("| from |   same state | same run | refined | need"));
  EXPECT_EQ(rows_of(table).size(), 2U);
  EXPECT_THAT(table, HasSubstr("pendulum: 1 body, 1 joint, 0 loops, 1 degree of freedom of which 0 modal\n"));
  EXPECT_THAT(table, HasSubstr("rtol 1e-11, refined 1e-13, cartesian by rk4, relative by rk4"));
  EXPECT_THAT(table, HasSubstr("\nagree pendulum: 10 of 10 components judged; passed: rank, same state 16.0"));
}

TEST_F(TableTest, WhatASolverCouldNotFindAtItsStartIsNotKnown) {
  Verdict verdict = verify(model_, cartesian_, relative_, {});
  verdict.solvers[0].rank = {};
  EXPECT_THAT(format_verdict(model_, verdict, false),
              HasSubstr("1 degree of freedom of which 0 modal\n  constraints at "
                        "the start: cartesian not known, relative 5 of rank 5"));
  verdict.solvers[1].rank = {};
  EXPECT_THAT(format_verdict(model_, verdict, false), HasSubstr(", degrees of freedom not known\n"));
}

TEST(ComponentCount, HoldsForceElementsToo) {
  Verdict verdict;
  verdict.name = "thrown";
  verdict.others.resize(5);
  for (QuantityRow& row : verdict.others) {
    row.quantity.kind = Kind::element;
    row.judgement = Judgement::agree;
  }
  verdict.others[1].judgement = Judgement::not_judged;
  verdict.others[4].quantity.kind = Kind::acceleration;
  EXPECT_EQ(count_components(verdict).judged, 3);
  EXPECT_EQ(count_components(verdict).total, 4);
  EXPECT_THAT(format_verdict(sprung_pendulum_model(), verdict, false), HasSubstr("thrown: 3 of 4 components judged"));
}

TEST_F(TableTest, TellsThatTheModelAsksForOtherDigits) {
  EXPECT_THAT(text(false), Not(HasSubstr("[[need]]")));
  NeedOverride need;
  need.same_run = 9.0;
  model_.needs.push_back(need);
  EXPECT_THAT(text(false), HasSubstr("of motions 7; [[need]] of the model asks otherwise\n"));
}

TEST_F(TableTest, NothingIsJudgedByARunThatStops) {
  relative_.cannot_integrate = true;
  EXPECT_THAT(text(false), HasSubstr("\nfailed pendulum: 0 of 10 components judged; "));
}

TEST_F(TableTest, AllHasEveryComponent) { EXPECT_EQ(rows_of(text(true)).size(), 10U); }

TEST_F(TableTest, TheCompactRowIsTheOneThatFails) {
  relative_.spoil = [](const State&, Evaluation& evaluation) {
    evaluation.joints[0].reaction[1].in_C.torque(1) += 1.0;
  };
  const std::string table = text(false);
  EXPECT_THAT(rows_of(table).at(1), HasSubstr("| T_y "));
  EXPECT_THAT(rows_of(table).at(1), HasSubstr("| differ"));
  EXPECT_THAT(table, HasSubstr("\nFAIL pendulum: joint A on bob, T_y, t = "));
  EXPECT_THAT(table, HasSubstr("\ndiffer pendulum: 10 of 10 components judged; passed: rank"));
  EXPECT_THAT(table, HasSubstr("not passed: same state"));
}

TEST_F(TableTest, WhoAgreesHasNotJudgedWhatDidNotPass) {
  Verdict verdict = verify(model_, cartesian_, relative_, {});
  ASSERT_EQ(verdict.outcome, Outcome::agree);
  EXPECT_THAT(format_verdict(model_, verdict, false), Not(HasSubstr("; not ")));
  verdict.same_run.passed = verdict.refined.passed = false;
  EXPECT_THAT(format_verdict(model_, verdict, false), HasSubstr("; not judged: same run"));
}

TEST_F(TableTest, TheReasonForALoweredNeedStandsInTheRow) {
  model_.needs.push_back({"A", "", "", "F_z", 5.0, {}, {}, "tested elsewhere", {}});
  const std::string table = text(false);
  EXPECT_THAT(table, HasSubstr("(need lowered: tested elsewhere)"));
  EXPECT_THAT(table, HasSubstr("5 / 7 / 8.5"));
}

TEST_F(TableTest, FailuresStopTheVerdict) {
  relative_.cannot_integrate = true;
  EXPECT_THAT(text(false), HasSubstr("\nSTOP pendulum: same run: relative: step size too small at t = 0.1 s\n"));
}

TEST_F(TableTest, TheLastLineSaysWhatCarriedTheVerdict) {
  Verdict verdict = verify(model_, cartesian_, relative_, {});
  QuantityRow& row = verdict.rows[2];
  row.same_run = 3.6;
  row.detail[static_cast<std::size_t>(Check::same_run)].unexplained = 16.0;
  verdict.same_run.digits = 3.6;
  const std::string line = "same run 3.6 (1 of 10 below 7 digits, within round-off), refined ";
  EXPECT_THAT(format_verdict(model_, verdict, false), HasSubstr(line));
  EXPECT_THAT(format_json(model_, verdict),
              HasSubstr("\"passed_with_less\": \"1 of 10 below 7 digits, within round-off\""));
  for (QuantityRow& one : verdict.rows) one.judgement = Judgement::not_judged;
  for (QuantityRow& one : verdict.rows) one.unique = false;
  PairSum sum;
  sum.samples = 3;
  verdict.pair_sums = {sum, sum};
  EXPECT_THAT(
      format_verdict(model_, verdict, false),
      HasSubstr("\nagree pendulum: 0 of 10 components judged: no single component is unique; judged instead: 2 totals "
                "of joints that share what they carry; passed: rank, same state"));
  EXPECT_THAT(format_json(model_, verdict), HasSubstr("\"judged_instead\": \"no single component is unique; "));
}

TEST_F(TableTest, IsTheSameFromRunToRun) {
  const std::string first = text(true);
  EXPECT_EQ(first, text(true));
  EXPECT_THAT(first, Not(HasSubstr("wall")));
}

}  // namespace
}  // namespace concord::compare
