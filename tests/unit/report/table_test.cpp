#include "compare/report/table.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <sstream>

#include "compare/quantities/observe.h"
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

  /// Lines of a table below its rule, by the words with which they begin: of the table of forces the joint, of that of
  /// components the case.
  static std::vector<std::string> rows_of(const std::string& text, const std::string& first) {
    std::vector<std::string> rows;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("| " + first + " ")) rows.push_back(line);
    }
    return rows;
  }

  Model model_ = pendulum_model();
  FakePendulum cartesian_{model_, "cartesian"};
  FakePendulum relative_{model_, "relative"};
};

TEST_F(TableTest, ForcesHaveOneRowForEachJointAndSide) {
  const std::string table = text(false);
  EXPECT_THAT(table, HasSubstr("| joint | on     | peak F [N] | at t [s] | peak T [N m] | at t [s] | digits (need) |"));
  EXPECT_EQ(rows_of(table, "A").size(), 2U);
  EXPECT_THAT(table, Not(HasSubstr("| scale |")));
  EXPECT_THAT(table, HasSubstr("pendulum: 1 body, 1 joint, 0 loops, 1 degree of freedom of which 0 modal\n"));
  EXPECT_THAT(table, HasSubstr("rtol 1e-11, refined 1e-12, cartesian by rk4, relative by rk4"));
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

TEST_F(TableTest, AllHasEveryComponentWithItsScaleBesideTheForces) {
  const std::string table = text(true);
  EXPECT_THAT(table, HasSubstr("| case     | joint | on     | component |"));
  EXPECT_THAT(table, HasSubstr("| from |   same state | same run | refined | need"));
  EXPECT_EQ(rows_of(table, "pendulum").size(), 10U);
  EXPECT_EQ(rows_of(table, "A").size(), 2U);
}

/// The random states, in which both solvers are asked, may load a joint far more than the motion does.
TEST_F(TableTest, PeaksAreThoseOfTheRunAtTheFirstTimeWithinAMillionth) {
  Verdict verdict = verify(model_, cartesian_, relative_, {});
  Trajectory& run = verdict.trajectories[0].value();
  const auto set = [&](std::size_t sample, double force) {
    for (SideWrench& side : run.samples[sample].evaluation.joints[0].reaction) side.in_C.force = {force, 0.0, 0.0};
  };
  set(100, 2000.0);
  set(60, -2000.0 * (1.0 - 0.9e-6));
  set(30, -2000.0 * (1.0 - 1.1e-6));
  const std::string time = fmt::format("{:.6g}", run.samples[60].state.t);
  EXPECT_THAT(rows_of(format_verdict(model_, verdict, false), "A").at(1), HasSubstr("|       2000 |     " + time));
  for (QuantityRow& row : verdict.rows) row.scale *= 17.0;
  EXPECT_THAT(rows_of(format_verdict(model_, verdict, false), "A").at(1), HasSubstr("|       2000 |     " + time));
}

TEST_F(TableTest, OfARowThatIsNotUniqueNoNumberIsShown) {
  Verdict verdict = verify(model_, cartesian_, relative_, {});
  const QuantityLayout layout(model_);
  const int first = layout.first_row(Kind::reaction, 0, Side::child);
  verdict.unique.value().row(first + 2).setConstant(false);  // F_z
  for (const int torque : {3, 4}) verdict.unique.value().row(first + torque).setConstant(false);
  Trajectory& run = verdict.trajectories[0].value();
  for (Sample& sample : run.samples) {
    sample.evaluation.joints[0].reaction[index(Side::child)].in_C.force = {30.0, -40.0, 1e6};
  }
  const std::string row = rows_of(format_verdict(model_, verdict, false), "A").at(1);
  EXPECT_THAT(row, HasSubstr("|    50 (xy) |"));
  EXPECT_THAT(row, HasSubstr("|   not unique |        - |"));
  verdict.unique.reset();
  EXPECT_THAT(rows_of(format_verdict(model_, verdict, false), "A").at(1),
              HasSubstr("| bob    |          - |        - |"));
}

/// A machine passes a pose in which its axes line up: what is unique there alone is not unique in the run.
TEST_F(TableTest, UniqueAtAnIsolatedSampleIsNotUnique) {
  Verdict verdict = verify(model_, cartesian_, relative_, {});
  const int first = QuantityLayout(model_).first_row(Kind::reaction, 0, Side::child);
  for (int c = 0; c < 3; ++c) {
    verdict.unique.value().row(first + c).setConstant(false);
    verdict.unique.value()(first + c, 7) = true;
  }
  EXPECT_THAT(rows_of(format_verdict(model_, verdict, false), "A").at(1), HasSubstr("| not unique |        - |"));
}

TEST_F(TableTest, ActorsAndForceElementsHaveRowsWithTheirVerdict) {
  model_ = sprung_pendulum_model();
  const std::string table = text(false);
  EXPECT_EQ(rows_of(table, "rubber").size(), 2U);
  const auto springs = rows_of(table, "spring of joint A");
  ASSERT_EQ(springs.size(), 1U);
  EXPECT_THAT(springs[0], HasSubstr("| turn_z | "));
  EXPECT_THAT(springs[0], HasSubstr(" N m | "));
  EXPECT_THAT(springs[0], ::testing::EndsWith("| agree   |"));
}

TEST_F(TableTest, ARowShowsTheComponentThatFails) {
  relative_.spoil = [](const State&, Evaluation& evaluation) {
    evaluation.joints[0].reaction[1].in_C.torque(1) += 1.0;
  };
  const std::string table = text(false);
  EXPECT_THAT(rows_of(table, "A").at(1), HasSubstr("T_y "));
  EXPECT_THAT(rows_of(table, "A").at(1), HasSubstr("| differ"));
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

TEST_F(TableTest, TheReasonForALoweredNeedStandsBelowTheForces) {
  model_.needs.push_back({"A", "", "", "F_z", 5.0, {}, {}, "tested elsewhere", {}});
  const std::string table = text(false);
  EXPECT_THAT(table, HasSubstr("\nneed lowered: joint A on ground, F_z: 5 / 7 / 8.5: tested elsewhere\n"));
  EXPECT_THAT(table, HasSubstr("\nneed lowered: joint A on bob, F_z: 5 / 7 / 8.5: tested elsewhere\n"));
  EXPECT_THAT(text(true), HasSubstr("(need lowered: tested elsewhere)"));
}

TEST_F(TableTest, EnergyShowsTheDriftItselfBesideWhatIsAllowed) {
  Verdict verdict = verify(model_, cartesian_, relative_, {});
  verdict.energy_allowed = 1e-8;
  for (SolverSummary& solver : verdict.solvers) {
    solver.energy_error = 0.0;  // all of it is round-off
    solver.energy = {.scale = 2.0, .drift = 3e-15, .t_drift = 0.3, .round_off = 4e-15};
  }
  EXPECT_THAT(format_verdict(model_, verdict, false),
              HasSubstr("\nenergy drift: cartesian 3.0e-15 J at t = 0.3 s, allowed 2.0e-08 J; relative 3.0e-15 J at "));
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
