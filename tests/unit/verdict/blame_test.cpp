#include "compare/verdict/blame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "compare/verdict/verify.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

using ::testing::HasSubstr;

/// A stand-in that refuses starts, or permits other velocities.
class StubbornPendulum : public FakePendulum {
 public:
  using FakePendulum::FakePendulum;

  bool refuses_start = false;
  double tilt = 0.0;

  State assemble() override {
    if (refuses_start) throw InputError({"pendulum.toml", 3, 1}, "the start values contradict each other");
    return FakePendulum::assemble();
  }
  MatX tangent(const State& state) override {
    MatX velocities = FakePendulum::tangent(state);
    velocities(3) += tilt;
    return velocities;
  }
};

class BlameTest : public ::testing::Test {
 protected:
  Verdict verdict() {
    VerifyOptions options;
    options.refines = false;
    return verify(model_, right_, wrong_, options);
  }

  void expect_blamed(const Verdict& verdict, Term term, const std::string& where) {
    ASSERT_TRUE(verdict.attribution);
    EXPECT_EQ(verdict.attribution->solver, 1);
    EXPECT_STREQ(name_of(verdict.attribution->term), name_of(term));
    EXPECT_EQ(verdict.attribution->where, where);
    EXPECT_THAT(verdict.notes, ::testing::Contains(HasSubstr("to blame: relative, at " + where)));
  }

  Model model_ = pendulum_model();
  FakePendulum right_{model_, "cartesian"};
  StubbornPendulum wrong_{model_, "relative"};
};

TEST_F(BlameTest, AWrongRankIsNamed) {
  wrong_.spoil_rank = [](RankReport& report) {
    --report.rank;
    ++report.degrees_of_freedom;
  };
  const Verdict found = verdict();
  EXPECT_EQ(found.outcome, Outcome::differ);
  expect_blamed(found, Term::rank, "the machine as a whole");
  EXPECT_THAT(found.attribution->because, HasSubstr("finds rank 4 of 5 constraints and 2 degrees of freedom; the "
                                                    "joints themselves give 5 of 5 and 1"));
}

TEST_F(BlameTest, AStartThatASolverRefusesWronglyIsNoBadInput) {
  wrong_.refuses_start = true;
  wrong_.tilt = 0.1;
  const Verdict found = verdict();
  EXPECT_EQ(found.outcome, Outcome::failed);
  ASSERT_FALSE(found.failures.empty());
  EXPECT_THAT(found.failures[0], HasSubstr("relative refuses the start that cartesian finds"));
  EXPECT_THAT(found.failures[0], HasSubstr("the start values contradict each other"));
  expect_blamed(found, Term::jacobian, "joint A");
}

TEST_F(BlameTest, AStartThatASolverRefusesForNoKnownReasonIsBadInput) {
  wrong_.refuses_start = true;
  EXPECT_THROW(verdict(), InputError);
}

/// A verdict whose answers hold.
Verdict with_answers_that_hold() {
  Verdict verdict;
  verdict.solvers[0].name = "cartesian";
  verdict.solvers[1].name = "relative";
  verdict.same_state.passed = verdict.same_run.passed = verdict.audit.passed = verdict.rank_agrees = true;
  verdict.energy_allowed = 1e-8;
  return verdict;
}

TEST(BlameOfRuns, NoRunIsToBlameWhereRanksDiffer) {
  Verdict verdict = with_answers_that_hold();
  EXPECT_TRUE(answers_hold(verdict));
  verdict.rank_agrees = false;
  EXPECT_FALSE(answers_hold(verdict));
}

TEST(BlameOfRuns, EnergyThatOneRunLosesAloneIsItsPower) {
  Verdict verdict = with_answers_that_hold();
  verdict.solvers[0].energy_error = 1e-12;
  verdict.solvers[1].energy_error = 1e-2;
  EXPECT_THAT(blame_of_run(verdict), HasSubstr("to blame: relative, in the power that it integrates"));
  verdict.same_run.passed = false;
  EXPECT_THAT(blame_of_run(verdict), HasSubstr("to blame: the run of relative, not what it answers"));
  verdict.same_run.passed = true;
  verdict.solvers[0].energy_error = 1e-2;
  EXPECT_THAT(blame_of_run(verdict), HasSubstr("to blame: a run"));
}

TEST(BlameOfRuns, TheRunThatStopsIsNamed) {
  Verdict verdict = with_answers_that_hold();
  verdict.trajectories[1].emplace();
  EXPECT_THAT(blame_of_stop(verdict), HasSubstr("to blame: the run of cartesian"));
  verdict.trajectories[0].swap(verdict.trajectories[1]);
  EXPECT_THAT(blame_of_stop(verdict), HasSubstr("to blame: the run of relative"));
}

}  // namespace
}  // namespace concord::compare
