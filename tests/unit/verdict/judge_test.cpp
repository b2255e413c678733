#include "compare/verdict/judge.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

/// What a judge makes of rows that agree to some digits, and of the audit.
class JudgeTest : public ::testing::Test {
 protected:
  void record_rows(Check check, double digits) {
    std::vector<Measured> measured(layout_.quantities().size());
    for (Measured& one : measured) {
      one.digits = one.unexplained_digits = digits;
      one.scale = 2.0;
      one.samples = 3;
    }
    record(layout_, measured, check, verdict_);
  }

  static AuditReport audited_to(double digits) {
    AuditReport report;
    report.states = 4;
    report.worst.digits = digits;
    report.worst.where = "bob";
    return report;
  }

  Model model_ = pendulum_model();
  QuantityLayout layout_{model_};
  Verdict verdict_;
  Judge of_run_{layout_, {kChecks.begin(), kChecks.end()}, verdict_};
  Judge of_analysis_{layout_, {Check::same_state, Check::same_run}, verdict_};
};

TEST_F(JudgeTest, RowsNeedTheChecksOfTheirVerdictAndNoOther) {
  make_rows(layout_, verdict_);
  record_rows(Check::same_state, 13.0);
  record_rows(Check::same_run, 13.0);
  of_analysis_.judge_rows();
  EXPECT_EQ(verdict_.rows[0].judgement, Judgement::agree);
  EXPECT_TRUE(verdict_.same_run.passed);
  EXPECT_FALSE(verdict_.refined.passed) << "it has not run";
  of_run_.judge_rows();
  EXPECT_EQ(verdict_.rows[0].judgement, Judgement::not_judged) << "of a run, refined must say something too";
}

TEST_F(JudgeTest, ADifferenceOnOneCheckIsNotTakenBackByACheckThatSaysNothing) {
  make_rows(layout_, verdict_);
  record_rows(Check::same_state, 3.0);
  of_analysis_.judge_rows();
  EXPECT_EQ(verdict_.rows[0].judgement, Judgement::differ);
}

TEST_F(JudgeTest, AnAuditBelowItsNeedIsAFindingThatNamesTheSolver) {
  verdict_.solvers[0].name = "cartesian";
  verdict_.solvers[1].name = "relative";
  of_run_.judge_audit(Who::cartesian, audited_to(14.0));
  EXPECT_TRUE(verdict_.findings.empty());
  of_run_.judge_audit(Who::relative, audited_to(3.0));
  ASSERT_EQ(verdict_.findings.size(), 1U);
  EXPECT_EQ(verdict_.findings[0].what.substr(0, 8), "relative");
  EXPECT_EQ(verdict_.audit.digits, 3.0);
  EXPECT_EQ(verdict_.audit.samples, 4);
  of_run_.judge_rows();
  EXPECT_FALSE(verdict_.audit.passed);
}

TEST_F(JudgeTest, AnAuditOfNoStateSaysNothing) {
  AuditReport nothing = audited_to(3.0);
  nothing.states = 0;
  of_run_.judge_audit(Who::cartesian, nothing);
  EXPECT_TRUE(verdict_.findings.empty());
  EXPECT_FALSE(verdict_.solvers[0].audit_digits);
}

TEST_F(JudgeTest, AFailureOutweighsADifference) {
  conclude(verdict_);
  EXPECT_EQ(verdict_.outcome, Outcome::agree);
  verdict_.findings.push_back({"a difference", ""});
  conclude(verdict_);
  EXPECT_EQ(verdict_.outcome, Outcome::differ);
  verdict_.failures.emplace_back("no verdict");
  conclude(verdict_);
  EXPECT_EQ(verdict_.outcome, Outcome::failed);
}

TEST_F(JudgeTest, ReportedCoordinatesThatAreNotTheBodiesAreAFinding) {
  verdict_.solvers[1].name = "relative";
  of_run_.judge_reported(Who::relative, {14.0, "joint 'A', turn_z", 0.1, 0.3, 0.3});
  EXPECT_TRUE(verdict_.findings.empty());
  of_run_.judge_reported(Who::relative, {2.0, "joint 'A', turn_z", 0.1, 0.3, 0.297});
  ASSERT_EQ(verdict_.findings.size(), 1U);
  EXPECT_EQ(verdict_.findings[0].what,
            "relative reports joint coordinates that its bodies do not have: joint 'A', turn_z, t = 0.1 s: 0.3 in "
            "place of 0.297, 2.0 digits (need 9)");
  of_run_.judge_rows();
  EXPECT_FALSE(verdict_.audit.passed);
}

/// Finds a comparator that agrees though one of its checks is not passed.
TEST_F(JudgeTest, ACheckThatIsNotPassedWithoutAFindingIsAFailure) {
  const auto agreeing = [] {
    Verdict verdict;
    verdict.outcome = Outcome::agree;
    verdict.rank_agrees = true;
    for (CheckSummary* check : {&verdict.same_state, &verdict.same_run, &verdict.refined, &verdict.audit}) {
      check->digits = 13.0;
      check->passed = true;
    }
    for (SolverSummary& solver : verdict.solvers) solver.energy_error = 0.0;
    return verdict;
  };
  const auto outcome_with = [&](const std::function<void(Verdict&)>& spoil) {
    Verdict verdict = agreeing();
    spoil(verdict);
    require_passed_checks(verdict);
    return verdict.outcome;
  };
  EXPECT_EQ(outcome_with([](Verdict&) {}), Outcome::agree);
  EXPECT_EQ(outcome_with([](Verdict& v) { v.rank_agrees = false; }), Outcome::failed);
  EXPECT_EQ(outcome_with([](Verdict& v) { v.same_run.passed = false; }), Outcome::failed);
  EXPECT_EQ(outcome_with([](Verdict& v) { v.audit.passed = false; }), Outcome::failed);
  EXPECT_EQ(outcome_with([](Verdict& v) { v.solvers[1].energy_error = 1.0; }), Outcome::failed);
  EXPECT_EQ(outcome_with([](Verdict& v) { v.refined = CheckSummary(); }), Outcome::agree);  // nothing was judged there
}

}  // namespace
}  // namespace concord::compare
