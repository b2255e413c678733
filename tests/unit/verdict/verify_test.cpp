#include "compare/verdict/verify.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <string>

#include "compare/report/table.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// Two stand-ins that agree to 1e-9 or so, as two integrators would.
class VerifyTest : public ::testing::Test {
 protected:
  VerifyTest() { relative_.drift = 1.0; }

  Verdict judge(const VerifyOptions& options = {}) { return verify(model_, cartesian_, relative_, options); }

  /// Changes the reaction and the total wrench on the child alike.
  void spoil_child(const std::function<void(SideWrench&)>& fault) {
    relative_.spoil = [fault](const State&, Evaluation& evaluation) {
      fault(evaluation.joints[0].reaction[index(Side::child)]);
      fault(evaluation.joints[0].total[index(Side::child)]);
    };
  }

  /// After its own run, relative does not accept the first state of time t that it is given.
  void refuse_after_the_run(double t) {
    relative_.spoil_run = [this, t](Trajectory&) {
      relative_.spoil = [t, refused = false](const State& state, Evaluation&) mutable {
        if (refused || std::abs(state.t - t) > 1e-9) return;
        refused = true;
        throw SolverError("relative: joint 'A' is open by 1e-3 m");
      };
    };
  }

  Model model_ = pendulum_model();
  FakePendulum cartesian_{model_, "cartesian"};
  FakePendulum relative_{model_, "relative"};
};

TEST_F(VerifyTest, AgreesAndPassesEveryCheck) {
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::agree) << format_verdict(model_, verdict, true);
  EXPECT_EQ(verdict.judged, 10);  // a hinge carries five components on each side
  EXPECT_EQ(verdict.total, 10);
  EXPECT_TRUE(verdict.rank_agrees && verdict.same_state.passed && verdict.same_run.passed && verdict.refined.passed &&
              verdict.audit.passed);
  EXPECT_GE(verdict.same_state.samples, 251);
  EXPECT_EQ(verdict.same_run.samples, 201);
  EXPECT_DOUBLE_EQ(verdict.run.rtol, kRigidRtol);
  EXPECT_GT(*verdict.same_run.digits, 9.0);
  EXPECT_GT(*verdict.refined.digits, *verdict.same_run.digits);
  EXPECT_EQ(exit_code(verdict.outcome), 0);
}

/// Detects a seed that is printed but not used.
TEST_F(VerifyTest, TheSeedChoosesTheRandomStates) {
  VerifyOptions options;
  options.refines = false;
  const auto resolvable = [&] {
    const Verdict verdict = judge(options);
    EXPECT_THAT(format_verdict(model_, verdict, false), HasSubstr(fmt::format("perturbed with seed {}", options.seed)));
    return verdict.rows.at(0).detail.at(0).resolvable.value();
  };
  const double by_default = resolvable();
  options.seed = 7;
  const double by_another = resolvable();
  EXPECT_NE(by_another, by_default);
  EXPECT_EQ(by_another, resolvable());
}

TEST_F(VerifyTest, OppositeSignIsADifference) {
  spoil_child([](SideWrench& wrench) { wrench.in_C.torque(0) *= -1.0; });
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  ASSERT_FALSE(verdict.findings.empty());
  EXPECT_THAT(verdict.findings[0].what, HasSubstr("joint A on bob, T_x, t = "));
  EXPECT_THAT(verdict.findings[0].what, HasSubstr(" N m, 0.5 digits (need 12)"));
  EXPECT_THAT(verdict.findings[0].symptom, HasSubstr("same state: same size, opposite sign in all 251 samples"));
  EXPECT_EQ(exit_code(verdict.outcome), 1);
}

TEST_F(VerifyTest, AWrongTotalWrenchAloneIsADifference) {
  relative_.spoil = [](const State&, Evaluation& evaluation) {
    evaluation.joints[0].total[index(Side::parent)].in_C.force(2) *= 1.0 + 1e-9;
  };
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  EXPECT_THAT(verdict.findings.at(0).what, HasSubstr("joint A on ground (total wrench), F_z"));
}

TEST_F(VerifyTest, AWrongAccelerationAloneIsADifference) {
  relative_.spoil = [](const State&, Evaluation& evaluation) { evaluation.bodies[1].omegadot(1) *= 1.0 + 1e-9; };
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  EXPECT_THAT(verdict.findings.at(0).what, HasSubstr("body bob, omegadot_y"));
}

TEST_F(VerifyTest, BothWrongAlikeIsFoundByTheAudit) {
  const auto fault = [](const State&, Evaluation& evaluation) {
    for (auto& side : evaluation.joints[0].reaction) side.in_C.force *= 1.001;
    for (auto& side : evaluation.joints[0].reaction) side.in_global.force *= 1.001;
    evaluation.joints[0].total = evaluation.joints[0].reaction;
  };
  cartesian_.spoil = relative_.spoil = fault;
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  EXPECT_TRUE(verdict.same_state.passed);
  EXPECT_FALSE(verdict.audit.passed);
  EXPECT_THAT(verdict.findings.at(0).what, HasSubstr("cartesian is not in balance"));
}

TEST_F(VerifyTest, SpringsAndForceElementsAreComparedAndAudited) {
  model_ = sprung_pendulum_model();
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::agree) << format_verdict(model_, verdict, true);
  EXPECT_EQ(verdict.judged, 10);
  const std::string table = format_verdict(model_, verdict, false);
  EXPECT_THAT(table, HasSubstr("| force element | on "));
  EXPECT_THAT(table, HasSubstr("| rubber        | ground | "));
  EXPECT_THAT(table, HasSubstr(", force elements 16.0"));
}

TEST_F(VerifyTest, AWrongElementIsNamed) {
  model_ = sprung_pendulum_model();
  relative_.spoil = [](const State&, Evaluation& evaluation) {
    evaluation.elements[1].on[index(Side::child)].in_C.torque(1) *= 1.0 + 1e-9;
  };
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  EXPECT_THAT(verdict.findings.at(0).what, HasSubstr("force element rubber on bob, T_y, t = "));
}

TEST_F(VerifyTest, AnElementThatBothTakeForAnotherLawIsFoundByTheAudit) {
  model_ = sprung_pendulum_model();
  cartesian_.spoil = relative_.spoil = [](const State&, Evaluation& evaluation) {
    for (SideWrench& side : evaluation.elements[0].on) {
      for (Wrench* wrench : {&side.in_C, &side.in_global}) wrench->force *= 1.001;
    }
  };
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  EXPECT_TRUE(verdict.same_state.passed);
  EXPECT_THAT(verdict.findings.at(0).what, HasSubstr("cartesian is not in balance: "));
}

TEST_F(VerifyTest, ASpringLeftInTheReactionIsFoundByTheAudit) {
  model_ = sprung_pendulum_model();
  cartesian_.spoil = relative_.spoil = [](const State&, Evaluation& evaluation) {
    evaluation.joints[0].reaction = evaluation.joints[0].total;
  };
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  EXPECT_THAT(verdict.findings.at(0).what, HasSubstr("cartesian is not in balance: workless: A, "));
}

TEST_F(VerifyTest, ADriftThatFallsWithTheToleranceIsFollowedToWhereItMeetsTheNeed) {
  relative_.drift = 5e4;
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::agree);
  EXPECT_TRUE(verdict.same_run.passed);
  EXPECT_LT(verdict.run.rtol, run_options(model_, {}).rtol);
  EXPECT_THAT(verdict.notes, Contains(HasSubstr("same run: repeated at rtol ")));
}

/// Both solvers' own runs move by as much as they differ: neither can be compared with the other.
TEST_F(VerifyTest, DriftsOfBothThatFallTooSlowlyAreRunsThatDoNotConverge) {
  cartesian_.drift = -4e8;
  relative_.drift = 1e9;
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::failed);
  EXPECT_TRUE(verdict.same_state.passed);
  EXPECT_FALSE(verdict.same_run.passed);
  EXPECT_THAT(verdict.failures, Contains(HasSubstr("same run: the runs do not converge")));
  for (const QuantityRow& row : verdict.rows) EXPECT_NE(row.judgement, Judgement::differ);
}

/// An integrator that holds its steps no tighter than at the tolerance of the same run leaves the same error on the
/// refined check. What tolerance changes is looked for at a looser one: nothing is told apart, and no solver differs.
TEST_F(VerifyTest, ARunThatGetsNoTighterIsNoDifference) {
  model_.run.rtol = 1e-9;
  cartesian_.drift = 1.1e3;
  cartesian_.finest = 3.1e-11;
  relative_.drift = 130.0;
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::failed);
  EXPECT_TRUE(verdict.same_run.passed);
  EXPECT_FALSE(verdict.refined.passed);
  EXPECT_THAT(verdict.failures, Contains(AllOf(HasSubstr("refined: the runs do not converge"),
                                               HasSubstr("the cartesian run is the same at rtol 1e-13 as at a looser "
                                                         "one: rk4 holds its steps no tighter, another "
                                                         "integrator (--cartesian-integrator) may"))));
  for (const QuantityRow& row : verdict.rows) EXPECT_NE(row.judgement, Judgement::differ);
}

/// The same where the other solver's runs are the same at every tolerance: who moves alone is who holds its steps.
TEST_F(VerifyTest, ARunThatGetsNoTighterAndMovesAloneIsNoDifference) {
  model_.run.rtol = 1e-9;
  cartesian_.drift = 1.1e3;
  cartesian_.finest = 3.1e-11;
  relative_.drift = 0.0;
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::failed);
  EXPECT_THAT(verdict.failures, Contains(AllOf(HasSubstr("refined: the runs do not converge"),
                                               HasSubstr("another integrator (--cartesian-integrator) may"))));
  for (const QuantityRow& row : verdict.rows) EXPECT_NE(row.judgement, Judgement::differ);
}

/// Where one solver's run moves and the other's does not, the integration of the one is at fault.
TEST_F(VerifyTest, ADriftOfOneAloneIsADifference) {
  relative_.drift = 1e9;
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  EXPECT_TRUE(verdict.same_state.passed);
  EXPECT_THAT(verdict.findings.at(0).symptom, HasSubstr("same run: "));
  EXPECT_FALSE(verdict.attribution);
  EXPECT_THAT(verdict.notes, Contains(HasSubstr("to blame: the run of relative, not what it answers")));
}

/// Where ten times are not enough, the refined check goes on as far as its digits ask. Who has converged by its own two
/// runs does not run a third time.
TEST_F(VerifyTest, RefinedIsTightenedAsFarAsItsDigitsAsk) {
  std::array<int, 2> runs{};
  model_.run.rtol = 1e-9;
  cartesian_.drift = 160.0;
  relative_.drift = 0.0;
  cartesian_.spoil_run = [&](Trajectory&) { ++runs[0]; };
  relative_.spoil_run = [&](Trajectory&) { ++runs[1]; };
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::agree) << format_verdict(model_, verdict, true);
  EXPECT_LT(*verdict.same_run.digits, 7.5);
  EXPECT_LT(*verdict.refined_rtol, 0.09 * verdict.run.rtol);
  EXPECT_GE(*verdict.refined_rtol, 0.0099 * verdict.run.rtol);
  EXPECT_EQ(runs, (std::array{3, 2}));
  runs = {};
  cartesian_.drift = 15.0;  // a tenth of that is enough already
  const Verdict nearer = judge();
  EXPECT_EQ(nearer.outcome, Outcome::agree);
  EXPECT_DOUBLE_EQ(*nearer.refined_rtol, 0.1 * nearer.run.rtol);
  EXPECT_EQ(runs, (std::array{2, 2}));
}

/// Makes stand-ins that drift like those of the test.
class Makers {
 public:
  Makers(const FakePendulum& cartesian, const FakePendulum& relative) : makers_{of(cartesian), of(relative)} {}

  [[nodiscard]] const SolverMakers& all() const { return makers_; }

 private:
  static std::function<std::unique_ptr<Solver>(const Model&)> of(const FakePendulum& like) {
    return [&like](const Model& model) {
      auto made = std::make_unique<FakePendulum>(model, std::string(like.name()));
      made->drift = like.drift;
      made->finest = like.finest;
      return made;
    };
  }

  SolverMakers makers_;
};

TEST_F(VerifyTest, RunsBesideEachOtherTellWhatRunsOneAfterTheOtherTell) {
  const std::string one_after_the_other = format_verdict(model_, judge(), true);
  std::array<int, 2> runs{};
  cartesian_.spoil_run = [&](Trajectory&) { ++runs[0]; };
  relative_.spoil_run = [&](Trajectory&) { ++runs[1]; };
  const Makers makers(cartesian_, relative_);
  VerifyOptions options;
  options.makers = &makers.all();
  EXPECT_EQ(format_verdict(model_, judge(options), true), one_after_the_other);
  EXPECT_EQ(runs, (std::array{1, 1}));
}

/// Runs that begin beside others end when nobody wants them any more.
TEST_F(VerifyTest, RunsThatAreNotWantedAreAbandoned) {
  class Endless : public FakePendulum {
   public:
    using FakePendulum::FakePendulum;
    Trajectory integrate(const RunOptions& /*options*/, const Progress& progress) override {
      for (;;) progress(0.0);
    }
  };
  const SolverMakers makers{[](const Model& model) { return std::make_unique<Endless>(model, "cartesian"); },
                            [](const Model& model) { return std::make_unique<Endless>(model, "relative"); }};
  VerifyOptions options;
  options.makers = &makers;
  options.explains = false;
  relative_.cannot_integrate = true;
  const Verdict verdict = judge(options);
  EXPECT_EQ(verdict.outcome, Outcome::failed);
  EXPECT_THAT(verdict.failures, Contains(HasSubstr("same run: relative: step size too small")));
}

TEST_F(VerifyTest, WithoutRunsStatesAreJudgedAndNothingElse) {
  cartesian_.cannot_integrate = relative_.cannot_integrate = true;
  VerifyOptions options;
  options.integrates = false;
  const Verdict verdict = judge(options);
  EXPECT_EQ(verdict.outcome, Outcome::agree) << format_verdict(model_, verdict, true);
  EXPECT_EQ(verdict.judged, 10);
  EXPECT_EQ(verdict.same_state.samples, 54);  // start and step of both, and 50 that are drawn
  EXPECT_FALSE(verdict.same_run.digits || verdict.refined.digits);
  EXPECT_TRUE(verdict.audit.passed);
  EXPECT_GT(verdict.trajectories[0]->samples.at(1).state.t, 0.0);
  const std::string table = format_verdict(model_, verdict, false);
  EXPECT_THAT(table, HasSubstr("\n  no run: the start, a short step from it, and states drawn near these\n"
                               "  digits needed: same state 12, audit 9, of motions 7\n"));
  EXPECT_THAT(table, ::testing::ContainsRegex("; passed: rank, same state [0-9.]+, audit [0-9.]+\n$"));
}

TEST_F(VerifyTest, WithoutRunsADifferenceIsADifference) {
  VerifyOptions options;
  options.integrates = false;
  relative_.spoil = [](const State& state, Evaluation& evaluation) {
    if (state.t > 0.0) evaluation.joints[0].reaction[1].in_C.force(0) *= 1.0 + 1e-9;
  };
  const Verdict verdict = judge(options);
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  EXPECT_THAT(verdict.findings.at(0).what, HasSubstr("joint A on bob, F_x, t = "));
  relative_.spoil = [](const State&, Evaluation&) { throw SolverError("relative: joint 'A' is open by 1e-3 m"); };
  EXPECT_EQ(judge(options).outcome, Outcome::failed);
}

TEST_F(VerifyTest, ADriftThatStaysFailsTheRefinedCheck) {
  model_.needs.push_back({"", "", "", "", {}, 3.0, {}, "the drift is under test", {}});
  relative_.spoil_run = [](Trajectory& run) {
    for (Sample& sample : run.samples) sample.evaluation.joints[0].reaction[1].in_C.force(0) *= 1.0 + 1e-5;
  };
  const Verdict verdict = judge();
  EXPECT_FALSE(verdict.refined.passed);
  EXPECT_EQ(verdict.outcome, Outcome::differ);
}

TEST_F(VerifyTest, NotANumberIsNoVerdict) {
  spoil_child([](SideWrench& wrench) { wrench.in_C.force(1) = std::numeric_limits<double>::quiet_NaN(); });
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::failed);
  EXPECT_EQ(verdict.failures.at(0), "relative: joint A on bob, F_y is not a number at t = 0 s");
  EXPECT_EQ(exit_code(verdict.outcome), 3);
}

TEST_F(VerifyTest, AMissingJointIsNoVerdict) {
  relative_.spoil = [](const State&, Evaluation& evaluation) { evaluation.joints.clear(); };
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::failed);
  EXPECT_THAT(verdict.failures.at(0), HasSubstr("0 joints in the evaluation, expected 1"));
}

TEST_F(VerifyTest, FewerSamplesThanAskedIsNoVerdict) {
  relative_.spoil_run = [](Trajectory& run) { run.samples.pop_back(); };
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::failed);
  EXPECT_EQ(verdict.failures.at(0), "relative: 200 samples, 201 were asked for");
}

TEST_F(VerifyTest, ARunThatCarriesNothingIsNoVerdict) {
  model_.gravity.setZero();
  model_.joints[0].start[0].u(0) = 0.0;
  const Verdict verdict = judge();  // the perturbed states carry something
  EXPECT_GT(verdict.rows.front().scale, 0.0);
  EXPECT_EQ(verdict.outcome, Outcome::failed);
  EXPECT_THAT(verdict.failures, ::testing::ElementsAre("during the run no joint and no force element carries anything: "
                                                       "agreement on zeros is no verdict"));
}

TEST_F(VerifyTest, TheWholeTableSaysWhenEachRowDiffersMost) {
  relative_.spoil = [](const State& state, Evaluation& evaluation) {
    const double pulse = 1e-5 * std::exp(-std::pow((state.t - 0.13) / 0.02, 2));
    for (auto* wrenches : {&evaluation.joints[0].reaction, &evaluation.joints[0].total}) {
      (*wrenches)[index(Side::child)].in_C.force(1) += pulse;
    }
  };
  const std::string table = format_verdict(model_, judge(), true);
  EXPECT_THAT(table, HasSubstr("| worst at "));
  EXPECT_THAT(table, HasSubstr("| 0.13 s, same state "));
}

TEST_F(VerifyTest, NothingJudgedIsNoVerdict) {
  const auto all_redundant = [](RankReport& report) {
    for (auto& side : report.joints[0].unique) side.fill(false);
  };
  cartesian_.spoil_rank = relative_.spoil_rank = all_redundant;
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.judged, 0);
  EXPECT_EQ(verdict.outcome, Outcome::failed);
  EXPECT_THAT(verdict.failures, ::testing::Contains("no component was judged: none is unique, or none is resolved"));
}

TEST_F(VerifyTest, ComponentsThatAreNotUniqueAreNamedAndNotJudged) {
  const auto redundant = [](RankReport& report) {
    for (auto* unique : {&report.joints[0].unique, &report.joints[0].unique_total}) {
      (*unique)[index(Side::child)][2] = false;
      (*unique)[index(Side::parent)][2] = false;
    }
  };
  cartesian_.spoil_rank = relative_.spoil_rank = redundant;
  relative_.spoil = [](const State&, Evaluation& evaluation) {
    for (auto* wrenches : {&evaluation.joints[0].reaction, &evaluation.joints[0].total}) {
      for (auto& side : *wrenches) side.in_C.force(2) += 5.0;
    }
  };
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.judged, 8);
  EXPECT_EQ(verdict.total, 10);
  EXPECT_TRUE(verdict.same_state.passed);
  EXPECT_THAT(format_verdict(model_, verdict, false), HasSubstr("not unique, not judged: joint A on bob: F_z\n"));
}

TEST_F(VerifyTest, DisagreementOnUniquenessIsADifference) {
  relative_.spoil_rank = [](RankReport& report) { report.joints[0].unique[index(Side::child)][0] = false; };
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  EXPECT_FALSE(verdict.rank_agrees);
  EXPECT_EQ(
      verdict.findings.at(0).what,
      "rank: joint A on bob, F_x is unique for cartesian, not unique for relative, in 251 of 251 states, first at "
      "t = 0 s");
}

TEST_F(VerifyTest, AnUndecidedRankIsToldAndWhatDependsOnItIsNotJudged) {
  cartesian_.spoil_rank = [](RankReport& report) {
    report.undecided = true;
    report.decided.resize(1);
    report.decided[0].unique[index(Side::child)][0] = false;
  };
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::agree) << format_verdict(model_, verdict, true);
  EXPECT_EQ(verdict.judged, 9);
  EXPECT_THAT(verdict.notes, ::testing::Contains(HasSubstr("cartesian: the rank of the constraints is undecided at")));
}

TEST_F(VerifyTest, AComponentIsJudgedInTheStatesInWhichItIsUnique) {
  // Not unique in the first half of the run; wrong in those states alone.
  const auto in_first_half = [](double t) { return t < 0.1; };
  double t_of_rank = 0.0;
  const auto of_state = [&](RankReport& report) {
    if (!in_first_half(t_of_rank)) return;
    for (auto* unique : {&report.joints[0].unique, &report.joints[0].unique_total}) {
      for (auto& side : *unique) side[2] = false;
    }
  };
  cartesian_.see_rank = relative_.see_rank = [&](const State& state) { t_of_rank = state.t; };
  cartesian_.spoil_rank = relative_.spoil_rank = of_state;
  relative_.spoil = [&](const State& state, Evaluation& evaluation) {
    if (!in_first_half(state.t)) return;
    for (auto* wrenches : {&evaluation.joints[0].reaction, &evaluation.joints[0].total}) {
      for (auto& side : *wrenches) side.in_C.force(2) += 5.0;
    }
  };
  const Verdict verdict = judge();
  EXPECT_TRUE(verdict.same_state.passed) << format_verdict(model_, verdict, true);
  EXPECT_EQ(verdict.judged, 10);
  EXPECT_THAT(format_verdict(model_, verdict, false), HasSubstr("judged where unique: joint A on bob, not unique in "));
}

TEST_F(VerifyTest, ASingularPoseIsNoVerdictAndIsNoDifference) {
  relative_.spoil_run = [this](Trajectory&) {
    relative_.spoil = [](const State& state, Evaluation&) {
      if (std::abs(state.t - 0.2) < 1e-9) throw SingularPose("relative: the loop of joint 'A' is singular");
    };
  };
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::failed);
  EXPECT_TRUE(verdict.findings.empty());
  EXPECT_EQ(verdict.failures.at(0), "relative: the loop of joint 'A' is singular");
}

TEST_F(VerifyTest, AStateThatOnlyItsOwnerAcceptsIsADifference) {
  refuse_after_the_run(0.2);  // an even sample: cartesian's
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  EXPECT_EQ(verdict.findings.at(0).what,
            "relative does not accept cartesian's state at t = 0.2 s: relative: joint 'A' is open by 1e-3 m");
}

TEST_F(VerifyTest, AStateThatItsOwnerDoesNotAcceptIsNoVerdict) {
  refuse_after_the_run(0.202);  // an odd sample: relative's
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::failed);
  EXPECT_THAT(verdict.failures.at(0), HasSubstr("relative does not accept its own state at t = 0.202 s"));
}

TEST_F(VerifyTest, ASolverThatStopsIsNoVerdictButTheSameStateIsStillJudged) {
  relative_.cannot_integrate = true;
  const Verdict verdict = judge();
  EXPECT_EQ(verdict.outcome, Outcome::failed);
  EXPECT_EQ(verdict.failures.at(0), "same run: relative: step size too small at t = 0.1 s");
  EXPECT_TRUE(verdict.same_state.digits.has_value());
  EXPECT_FALSE(verdict.same_run.digits.has_value());
  EXPECT_EQ(verdict.rows.at(0).judgement, Judgement::not_judged);
}

TEST_F(VerifyTest, OptionsGoBeforeTheModelAndTheModelBeforeTheDefaults) {
  model_.run.rtol = 1e-10;
  VerifyOptions options;
  EXPECT_DOUBLE_EQ(run_options(model_, options).rtol, 1e-10);
  EXPECT_EQ(run_options(model_, options).samples, 200);
  options.rtol = 1e-8;
  options.until = 0.1;
  options.samples = 7;
  const RunOptions run = run_options(model_, options);
  EXPECT_DOUBLE_EQ(run.rtol, 1e-8);
  EXPECT_DOUBLE_EQ(run.until, 0.1);
  EXPECT_EQ(run.samples, 7);
}

TEST_F(VerifyTest, FewSamplesAreJudgedOnAFinerGridAndKeptAsAsked) {
  VerifyOptions options;
  options.samples = 30;
  const Verdict verdict = judge(options);
  EXPECT_EQ(verdict.outcome, Outcome::agree);
  EXPECT_GE(verdict.same_run.samples, 200);
  EXPECT_EQ(verdict.trajectories[0]->samples.size(), 31U);
}

TEST_F(VerifyTest, AnUnknownIntegratorIsBadInput) {
  VerifyOptions options;
  options.integrators[1] = "euler";
  try {
    judge(options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "pendulum.toml: error: the relative solver has no integrator 'euler'; it has rk4, other");
  }
}

}  // namespace
}  // namespace concord::compare
