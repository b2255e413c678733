#include "compare/verdict/reference.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "common/error.h"
#include "compare/report/files.h"
#include "compare/report/table.h"
#include "compare/verdict/verify.h"
#include "tests/unit/fake_pendulum.h"
#include "tests/unit/temporary_folder.h"

namespace concord::compare {
namespace {

using ::testing::HasSubstr;

class ReferenceTest : public ::testing::Test {
 protected:
  Reference read(const std::string& text) {
    write_file(folder_.path() / "measured.csv", text);
    return read_reference(folder_.path() / "measured.csv", model_);
  }

  /// What the reader says about a text; empty if it reads.
  std::string complaint(const std::string& text) {
    try {
      read(text);
    } catch (const InputError& error) {
      const std::string said = error.what();
      return said.substr(said.find("measured.csv"));
    }
    return "";
  }

  /// The verdict on two solvers that agree.
  Verdict verified(const VerifyOptions& options = {}) {
    FakePendulum cartesian(model_, "cartesian");
    FakePendulum relative(model_, "relative");
    return verify(model_, cartesian, relative, options);
  }

  TemporaryFolder folder_;
  Model model_ = sprung_pendulum_model();
};

TEST_F(ReferenceTest, ReadsColumnsAndTheirStatedErrors) {
  const Reference reference = read(
      "# Somebody, 1997, fig. 3\n# error = 0.5 %\n# error strut.child.F_x = 0.2 N\n"
      "t [s],A.child.T_y [N m],strut.child.F_x [N]\n0,1.5,-2\n0.2, +1.25 ,3e-1\n");
  ASSERT_EQ(reference.columns.size(), 2U);
  EXPECT_EQ(quantity_of(reference.columns[0].column), (Quantity{Kind::reaction, 0, Side::child, 4}));
  EXPECT_TRUE(reference.columns[0].is_relative);
  EXPECT_DOUBLE_EQ(reference.columns[0].error, 0.005);
  EXPECT_EQ(quantity_of(reference.columns[1].column), (Quantity{Kind::element, 0, Side::child, 0}));
  EXPECT_FALSE(reference.columns[1].is_relative);
  EXPECT_DOUBLE_EQ(reference.columns[1].error, 0.2);
  EXPECT_EQ(reference.times, (std::vector<double>{0.0, 0.2}));
  EXPECT_EQ(reference.columns[0].values, (std::vector<double>{1.5, 1.25}));
}

TEST_F(ReferenceTest, ReadsOneLineANumber) {
  const Reference reference =
      read("t,of,component,value\n0.0,A,F_x,1.250\n0.0,A,parent.T_y,-2e-3\n0.1,A,tau_1,0.0\n0.1,A,F_x,-0.5\n");
  ASSERT_EQ(reference.columns.size(), 3U);
  EXPECT_EQ(reference.columns[0].column.name, "A.child.F_x");
  EXPECT_EQ(reference.columns[1].column.name, "A.parent.T_y");
  EXPECT_EQ(reference.columns[2].column.name, "A.tau_1");
  EXPECT_EQ(reference.times, (std::vector<double>{0.0, 0.1}));
  EXPECT_EQ(reference.columns[0].values, (std::vector<double>{1.25, -0.5}));
  EXPECT_EQ(reference.columns[1].values[0], -2e-3);
  EXPECT_TRUE(std::isnan(reference.columns[1].values[1]));
  EXPECT_TRUE(std::isnan(reference.columns[2].values[0]));
  EXPECT_FALSE(reference.columns[0].is_stated);
  EXPECT_EQ(reference.columns[0].digits, 4);
  EXPECT_EQ(reference.columns[1].digits, 1);
  EXPECT_EQ(reference.columns[2].digits, 0);
  EXPECT_THAT(complaint("t,of,component,value\n0,A,F_x\n"), HasSubstr(":2:1: error: reference: 3 fields, expected 4"));
  EXPECT_THAT(complaint("t,of,component,value\n0,A,F_x,1\n0,A,child.F_x,2\n"),
              HasSubstr(":3:3: error: reference: column 'A.child.F_x' stands there twice at t = 0 s"));
  EXPECT_EQ(read("t,of,component,value\n1,A,F_x,1\n0,A,F_x,2\n").columns[0].values, (std::vector<double>{2, 1}));
  EXPECT_THAT(complaint("t,of,component,value\n1,B,F_x,1\n"), HasSubstr("the model has no 'B.F_x'"));
}

TEST_F(ReferenceTest, WhereNoErrorIsStatedItIsOfTheDigitsAndAtMostAThousandthOfThePeak) {
  const Verdict verdict = verified();
  const double value =
      verdict.trajectories[0]->samples[100].evaluation.joints[0].reaction_on(Side::child).in_C.force(1);
  const auto row_with = [&](const std::string& said) {
    Verdict judged = verdict;
    judge_reference(model_, read("t [s],A.child.F_y [N]\n0.2," + said + "\n"), judged);
    EXPECT_THAT(judged.notes, ::testing::Contains(HasSubstr("reference: 1 of 1 columns state no error")));
    return judged.references.at(0);
  };
  const double power = std::pow(10.0, std::floor(std::log10(std::abs(value))));
  EXPECT_NEAR(row_with(fmt::format("{:.5e}", value)).allowed, 0.5e-5 * power, 1e-12 * power);
  EXPECT_TRUE(row_with(fmt::format("{:.5e}", value)).word == ReferenceWord::equal);
  EXPECT_FALSE(row_with(fmt::format("{:.5e}", value * (1.0 + 2e-5))).word == ReferenceWord::equal);
  const ReferenceRow coarse = row_with(fmt::format("{:.1e}", value));
  EXPECT_DOUBLE_EQ(coarse.allowed, 1e-3 * coarse.peak);
}

/// A long table of the hinge's wrench on the child at every tenth output time, each number as `said` of it and its
/// time.
std::string table_of(const Model& model, const Trajectory& run,
                     const std::function<double(double, std::size_t)>& said) {
  std::string text = "t,of,component,value\n";
  for (std::size_t k = 0; k < run.samples.size(); k += 10) {
    for (const Column& column : reaction_columns(model)) {
      if (!column.name.starts_with("A.child.")) continue;
      text += fmt::format("{},A,{},{:.14g}\n", run.samples[k].state.t, describe_component(column),
                          said(value_of(column, run.samples[k]), k));
    }
  }
  return text;
}

// An integrator at a tolerance of 1e-6 drifts away from an equal start, and writes all digits. A number beside that, or
// a machine under another gravity, is wrong: it starts off the digits.
TEST_F(ReferenceTest, ATableThatDriftsFromAnEqualStartIsEqualAtAnErrorThatIsTold) {
  const Verdict verdict = verified();
  const auto judged_with = [&](const std::function<double(double, std::size_t)>& said) {
    Verdict judged = verdict;
    judge_reference(model_, read(table_of(model_, *verdict.trajectories[0], said)), judged);
    return judged;
  };
  const auto drifting = [](double value, std::size_t k) { return value * (1.0 + 1e-8 * static_cast<double>(k)); };
  const Verdict good = judged_with(drifting);
  EXPECT_EQ(good.outcome, Outcome::agree);
  EXPECT_THAT(good.notes.back(),
              HasSubstr("from an equal start it drifts out of balance, and 6.9e-06 of the peak is taken"));
  const Verdict one_off =
      judged_with([&](double value, std::size_t k) { return drifting(value, k) * (k == 100 ? 1.0 + 1e-4 : 1.0); });
  EXPECT_EQ(one_off.outcome, Outcome::differ);
  EXPECT_THAT(one_off.findings.at(0).what, HasSubstr("at t = 0.2 s"));
  const Verdict other_gravity = judged_with([](double value, std::size_t) { return value * 9.81 / 9.80665; });
  EXPECT_EQ(other_gravity.outcome, Outcome::differ);
  EXPECT_THAT(other_gravity.notes.back(), Not(HasSubstr("drifts")));
  EXPECT_EQ(judged_with([](double value, std::size_t k) { return value * (k == 0 ? 1.0 : 1.01); }).outcome,
            Outcome::differ);
}

// No table can be held to more than both runs agree; the first of them is the table here.
TEST_F(ReferenceTest, WhereNoErrorIsStatedWhatBothRunsDifferByIsLeftOpen) {
  const Verdict verdict = verified();
  const std::string table = table_of(model_, *verdict.trajectories[0], [](double value, std::size_t) { return value; });
  for (const double part : {1e-7, 1e-2}) {
    Verdict judged = verdict;
    for (Sample& sample : judged.trajectories[1]->samples) {
      sample.evaluation.joints[0].reaction[1].in_C.force *= 1.0 + part;
    }
    judge_reference(model_, read(table), judged);
    EXPECT_EQ(judged.outcome, part < 1e-3 ? Outcome::agree : Outcome::differ) << part;
  }
}

// The hinge's forces and torques at 0.2 s, written in other conventions on purpose.
TEST_F(ReferenceTest, ASideAnAxisASignAndADriverTakenOtherwiseAreNamed) {
  const Verdict verdict = verified();
  const auto judged_with = [&](const std::string& header, const std::string& infix, double sign) {
    std::string text = "# error = 1e-4 %\n" + header + "t,of,component,value\n";
    for (const auto& columns : {reaction_columns(model_), further_columns(model_)}) {
      for (const Column& column : columns) {
        if (!column.name.starts_with("A." + infix + "F_") && !column.name.starts_with("A." + infix + "T_")) continue;
        const double value = sign * value_of(column, verdict.trajectories[0]->samples[100]);
        text += fmt::format("0.2,A,{},{:.15g}\n", describe_component(column), value);
      }
    }
    Verdict judged = verdict;
    judge_reference(model_, read(text), judged);
    return judged;
  };
  EXPECT_EQ(judged_with("", "child.", 1.0).outcome, Outcome::agree);
  struct Case {
    std::string infix;
    double sign;
    std::vector<std::string> lines;
  };
  const std::vector<Case> cases{{"parent.", 1.0, {"# side = parent"}},
                                {"child.global.", 1.0, {"# axes = world"}},
                                {"child.", -1.0, {"# sign = opposite"}},
                                {"child.total.", 1.0, {"# driver = with"}},
                                {"parent.global.", 1.0, {"# side = parent", "# axes = world"}}};
  for (const Case& one : cases) {
    const Verdict off = judged_with("", one.infix, one.sign);
    EXPECT_EQ(off.outcome, Outcome::differ) << one.infix;
    const std::string lines = fmt::format("`{}`", fmt::join(one.lines, "` and `"));
    EXPECT_THAT(off.findings.at(0).what, HasSubstr("equal in another convention: ")) << one.infix;
    EXPECT_THAT(off.findings.at(0).what, HasSubstr(lines)) << one.infix;
    EXPECT_FALSE(off.attribution.has_value());
    const std::string header = fmt::format("{}\n", fmt::join(one.lines, "\n"));
    EXPECT_EQ(judged_with(header, one.infix, one.sign).outcome, Outcome::agree) << header;
  }
  EXPECT_EQ(judged_with("# side A = parent\n", "parent.", 1.0).outcome, Outcome::agree);
  const Verdict wrong = judged_with("", "parent.", 1.1);
  EXPECT_EQ(wrong.outcome, Outcome::differ);
  for (const Finding& finding : wrong.findings) EXPECT_THAT(finding.what, Not(HasSubstr("another convention")));
}

TEST_F(ReferenceTest, AConventionThatIsNoneIsRefused) {
  EXPECT_THAT(complaint("# side = left\nt,of,component,value\n0,A,F_x,1\n"),
              HasSubstr(":1:1: error: reference: 'side = left': expected `side = child` or `parent`"));
  EXPECT_THAT(complaint("# axes B = world\nt,of,component,value\n0,A,F_x,1\n"),
              HasSubstr(":1:1: error: reference: a convention is stated for 'B', which is no joint"));
  EXPECT_THAT(complaint("# sign = same\n# sign = opposite\nt,of,component,value\n0,A,F_x,1\n"),
              HasSubstr(":2:1: error: reference: 'sign' is stated already"));
}

TEST_F(ReferenceTest, ASpreadsheetsMarkIsNoPartOfTheFirstColumn) {
  EXPECT_EQ(read("\xEF\xBB\xBFt [s],A.child.T_y [N m]\n# error = 0.5 %\n0,1.5\n").columns.size(), 1U);
}

TEST_F(ReferenceTest, SaysWhereAndWhy) {
  EXPECT_EQ(
      complaint("# error = 1 %\nt [s],B.child.F_x [N]\n0,1\n"),
      "measured.csv:2:7: error: reference: the model has no 'B.child.F_x': did you mean 'A.child.F_x'? Columns are "
      "called JOINT.child.F_x [N] ... JOINT.parent.T_z [N m], and as in all our result files");
  EXPECT_EQ(complaint("# error = 1 %\nt [s],A.child.F_x [kN]\n0,1\n"),
            "measured.csv:2:7: error: reference: column 'A.child.F_x [kN]': its unit must stand behind it: [N]");
  EXPECT_THAT(complaint("# error = 1 %\nt [s],A.child.F_x [N]\n0,none\n"), HasSubstr(":3:3: error: reference: 'none'"));
  EXPECT_THAT(complaint("# error = 1 %\nt [s],A.child.F_x [N]\n0,1\n0,1\n"), HasSubstr("times must rise"));
  EXPECT_THAT(complaint("# error = 1 %\nt [s],A.child.F_x [N]\n0,1,2\n"), HasSubstr("3 numbers, the header has 2"));
  EXPECT_THAT(complaint("# error = 1 %\nt [s],A.child.F_x [N],A.child.F_x [N]\n0,1,2\n"),
              HasSubstr("column 'A.child.F_x' stands there twice"));
  EXPECT_THAT(complaint("# error = 1 N\nt [s],A.child.F_x [N]\n0,1\n"),
              HasSubstr(":1:1: error: reference: the error of all columns is in %, found '1 N'"));
  EXPECT_THAT(complaint("# error A.child.F_x = 1 N m\nt [s],A.child.F_x [N]\n0,1\n"),
              HasSubstr("the error of 'A.child.F_x' is in N m, the column in N"));
}

TEST_F(ReferenceTest, AnErrorIsStatedOnceAndItsMistakesAreToldWhereTheyStand) {
  EXPECT_THAT(complaint("# error = 1 %\n# Error = 2 %\nt [s],A.child.F_x [N]\n0,1\n"),
              HasSubstr(":2:1: error: reference: the error of all columns is stated in line 1 already"));
  EXPECT_THAT(complaint("# error = 1 %\n# error A.child.F_z = 1 N\nt [s],A.child.F_x [N]\n0,1\n"),
              HasSubstr(":2:1: error: reference: an error is stated for 'A.child.F_z', which is no column"));
}

TEST_F(ReferenceTest, OtherSeparatorsAndOtherBytesAreNamed) {
  EXPECT_THAT(complaint("# error = 1 %\nt [s];A.child.F_x [N]\n0;1\n"), HasSubstr("by commas, not by semicolons"));
  EXPECT_THAT(complaint("# error = 1 %\nt [s]\tA.child.F_x [N]\n0\t1\n"), HasSubstr("by commas, not by tabs"));
  EXPECT_THAT(complaint(std::string("t\0 [s]", 6)), HasSubstr("holds a zero byte"));
}

TEST_F(ReferenceTest, ReadsWhatOurOwnFilesHold) {
  model_.joints[0].name = " the \"hinge\", A";
  const Reference reference =
      read("# error = 1 %\nt [s] ,\" the \"\"hinge\"\", A.child.F_x [N]\"\n0,-1.99e-151\n0.1, 1e-320 \n");
  EXPECT_EQ(reference.columns.at(0).column.name, " the \"hinge\", A.child.F_x");
  EXPECT_NEAR(reference.columns[0].values.at(0), 0.0, 1e-150);
  EXPECT_NEAR(reference.columns[0].values.at(1), 0.0, 1e-150);
  EXPECT_THAT(complaint("# error = 1 %\nt [s],bob.x [m]\n0,1e999\n"), HasSubstr("'1e999' is not a number of a size"));
}

TEST_F(ReferenceTest, BothSolversAreHeldAgainstItWithinItsStatedError) {
  Verdict verdict = verified();
  ASSERT_EQ(verdict.outcome, Outcome::agree);
  const double value =
      verdict.trajectories[0]->samples[100].evaluation.joints[0].reaction_on(Side::child).in_C.force(1);
  const auto against = [&](double said) {
    Verdict judged = verdict;
    judge_reference(model_, read(fmt::format("# error A.child.F_y = 0.01 N\nt [s],A.child.F_y [N]\n0.2,{}\n", said)),
                    judged);
    return judged;
  };
  const Verdict good = against(value + 0.009);
  EXPECT_EQ(good.outcome, Outcome::agree);
  EXPECT_TRUE(good.references.at(0).word == ReferenceWord::equal);
  EXPECT_NEAR(good.references[0].differences[0], 0.009, 1e-12);
  const Verdict bad = against(value + 0.011);
  EXPECT_EQ(bad.outcome, Outcome::differ);
  EXPECT_THAT(bad.findings.at(0).what, HasSubstr("joint A on bob, F_y, against the reference: off by 0.011"));
  EXPECT_THAT(format_verdict(model_, bad, false), HasSubstr("| joint A on bob       | F_y       |"));
  EXPECT_THAT(format_verdict(model_, bad, false), HasSubstr("not passed: reference"));
}

TEST_F(ReferenceTest, TakesEveryColumnOfOurOwnFiles) {
  const Verdict verdict = verified();
  const std::vector<Sample>& samples = verdict.trajectories[0]->samples;
  std::size_t tried = 0;
  for (const auto& columns :
       {motion_columns(model_), reaction_columns(model_), element_columns(model_), further_columns(model_)}) {
    for (const Column& column : columns) {
      const double value = value_of(column, samples[150]);
      const auto judged_with = [&](double said) {
        Verdict judged = verdict;
        judge_reference(
            model_,
            read(fmt::format("# error {0} = 1e-3 {1}\nt [s],{0} [{1}]\n0.3,{2}\n", column.name, column.unit, said)),
            judged);
        return judged;
      };
      const Verdict good = judged_with(value + 0.9e-3);
      EXPECT_EQ(good.outcome, Outcome::agree) << column.name;
      EXPECT_TRUE(good.references.at(0).word == ReferenceWord::equal) << column.name;
      const Verdict bad = judged_with(value + 1.1e-3 * (value < 0.0 ? -1.0 : 1.0));
      EXPECT_FALSE(bad.references.at(0).word == ReferenceWord::equal) << column.name;
      EXPECT_EQ(bad.outcome, bad.references[0].word != ReferenceWord::not_judged ? Outcome::differ : Outcome::agree)
          << column.name;
      EXPECT_FALSE(good.references[0].of.empty()) << column.name;
      ++tried;
    }
  }
  EXPECT_EQ(tried, 20U + 15U + 30U + 66U);
}

TEST_F(ReferenceTest, ErrorsInPercentOfMotionsAreOfThePeakOfTheirVector) {
  Verdict verdict = verified();
  double peak = 0.0;
  for (const Sample& sample : verdict.trajectories[0]->samples) {
    peak = std::max(peak, sample.state.bodies[1].v.norm());
  }
  judge_reference(model_, read("# error = 2 %\nt [s],bob.v_y [m/s],bob.e1 [1]\n0,0,0\n"), verdict);
  EXPECT_DOUBLE_EQ(verdict.references.at(0).allowed, 0.02 * peak);
  EXPECT_NEAR(verdict.references.at(1).allowed, 0.02, 1e-12);
  EXPECT_EQ(verdict.references[0].of, "body bob");
  EXPECT_EQ(verdict.references[0].component, "v_y");
}

// A pendulum whose frame stands at its hinge does not move there, but for the round-off of who wrote the reference.
TEST_F(ReferenceTest, APercentageOfAMotionThatIsNothingIsOfTheMachine) {
  const Verdict verdict = verified();
  const auto outcome_with = [&](double x) {
    Verdict judged = verdict;
    for (auto& run : judged.trajectories) {
      for (Sample& sample : run->samples) sample.state.bodies[1].r.setZero();
    }
    judge_reference(model_, read(fmt::format("# error = 1 %\nt [s],bob.x [m]\n0,{}\n", x)), judged);
    return judged.outcome;
  };
  EXPECT_EQ(outcome_with(1e-9), Outcome::agree);
  EXPECT_EQ(outcome_with(1e-3), Outcome::differ);
}

TEST_F(ReferenceTest, EulerParametersMayHaveEitherSign) {
  Verdict verdict = verified();
  const double e2 = verdict.trajectories[0]->samples[0].state.bodies[1].p(2);
  judge_reference(model_, read(fmt::format("# error = 0.001 %\nt [s],bob.e2 [1]\n0,{}\n", -e2)), verdict);
  EXPECT_TRUE(verdict.references.at(0).word == ReferenceWord::equal);
}

TEST_F(ReferenceTest, TheInverseOfARotationIsAnother) {
  const Verdict verdict = verified();
  const auto with_signs = [&](double of_scalar, double of_vector) {
    std::string text = "# error = 0.001 %\nt [s],bob.e0 [1],bob.e1 [1],bob.e2 [1],bob.e3 [1]\n";
    for (const std::size_t k : {0U, 70U, 200U}) {
      const Sample& sample = verdict.trajectories[0]->samples[k];
      const Vec4& p = sample.state.bodies[1].p;
      text += fmt::format("{},{},{},{},{}\n", sample.state.t, of_scalar * p(0), of_vector * p(1), of_vector * p(2),
                          of_vector * p(3));
    }
    Verdict judged = verdict;
    judge_reference(model_, read(text), judged);
    return judged;
  };
  EXPECT_EQ(with_signs(1.0, 1.0).outcome, Outcome::agree);
  EXPECT_EQ(with_signs(-1.0, -1.0).outcome, Outcome::agree);
  const Verdict inverse = with_signs(1.0, -1.0);
  EXPECT_EQ(inverse.outcome, Outcome::differ);
  EXPECT_THAT(inverse.findings.at(0).symptom, HasSubstr("it is the inverse rotation"));
  EXPECT_EQ(with_signs(-1.0, 1.0).outcome, Outcome::differ);
}

// One of the four with the other sign decides for all which sign fits best: then right ones miss by their own sign.
TEST_F(ReferenceTest, NoColumnIsSaidToFitItself) {
  Verdict verdict = verified();
  std::string text = "# error = 0.001 %\nt [s],bob.e0 [1],bob.e1 [1],bob.e2 [1],bob.e3 [1]\n";
  for (const std::size_t k : {0U, 70U, 200U}) {
    for (auto& run : verdict.trajectories) run->samples[k].state.bodies[1].p = Vec4(0.3, 0.8, 0.5, std::sqrt(0.02));
    text += fmt::format("{},0.3,-0.8,0.5,{:.17g}\n", verdict.trajectories[0]->samples[k].state.t, std::sqrt(0.02));
  }
  judge_reference(model_, read(text), verdict);
  ASSERT_EQ(verdict.outcome, Outcome::differ);
  for (const Finding& finding : verdict.findings) {
    for (const char* name : {"bob.e0", "bob.e1", "bob.e2", "bob.e3"}) {
      EXPECT_THAT(finding.symptom, Not(HasSubstr(std::string("agrees with ") + name)));
      EXPECT_THAT(finding.symptom, Not(HasSubstr("it is 1 times")));
    }
  }
}

/// The pendulum swings about its joint's z, which lies anyhow in the world: axes across the hinge mix x and y alone.
TEST_F(ReferenceTest, AGlobalComponentIsJudgedWhereWhatIsNotUniqueHasNoPartInIt) {
  Model model = pendulum_model();
  model.joints[0].sides[0].C = Mat3::Identity();
  FakePendulum cartesian(model, "cartesian");
  FakePendulum relative(model, "relative");
  for (FakePendulum* solver : {&cartesian, &relative}) {
    solver->spoil_rank = [](RankReport& report) {
      for (auto& side : report.joints[0].unique) side[2] = false;
    };
  }
  Verdict verdict = verify(model, cartesian, relative, {});
  const std::string file = "# error = 1 %\nt [s],A.parent.global.F_x [N],A.parent.global.F_z [N]\n0,1e6,1e6\n";
  write_file(folder_.path() / "measured.csv", file);
  judge_reference(model, read_reference(folder_.path() / "measured.csv", model), verdict);
  EXPECT_TRUE(verdict.references.at(0).word != ReferenceWord::not_judged);
  EXPECT_FALSE(verdict.references.at(1).word != ReferenceWord::not_judged);
  EXPECT_EQ(verdict.outcome, Outcome::differ);
}

/// In the second half of the run the torque about y is one of many, as our own file says by nan.
TEST_F(ReferenceTest, AColumnIsJudgedAtTheTimesAtWhichItIsUnique) {
  double t = 0.0;
  const auto spoil = [&](FakePendulum& solver) {
    solver.see_rank = [&](const State& state) { t = state.t; };
    solver.spoil_rank = [&](RankReport& report) { report.joints[0].unique[1][4] = t <= 0.2; };
  };
  FakePendulum cartesian(model_, "cartesian");
  FakePendulum relative(model_, "relative");
  spoil(cartesian);
  spoil(relative);
  const Verdict verdict = verify(model_, cartesian, relative, {});
  const double value = verdict.trajectories[0]->samples[50].evaluation.joints[0].reaction[1].in_C.torque.y();
  const auto against = [&](const std::string& rows) {
    Verdict judged = verdict;
    judge_reference(model_, read("# error = 1 %\nt [s],A.child.T_y [N m],any_A.child.T_y [N m]\n" + rows), judged);
    return judged;
  };
  const Verdict good = against(fmt::format("0.1,{},1e6\n0.3,1e6,1e6\n", value));
  EXPECT_EQ(good.outcome, Outcome::agree);
  EXPECT_TRUE(good.references.at(0).word != ReferenceWord::not_judged);
  EXPECT_FALSE(good.references.at(1).word != ReferenceWord::not_judged);
  EXPECT_EQ(good.references[1].component, "any_T_y");
  EXPECT_THAT(good.notes.back(), HasSubstr("reference: 1 number is not judged, because it is not clear whether"));
  EXPECT_EQ(against(fmt::format("0.1,{},0\n0.3,nan,0\n", value)).outcome, Outcome::agree);
  EXPECT_EQ(against(fmt::format("0.1,{},0\n0.3,nan,0\n", value + 1e3)).references.at(0).line, 3);
  EXPECT_EQ(against(fmt::format("0.1,{},0\n0.3,nan,0\n", value + 1e3)).outcome, Outcome::differ);
  for (const char* unjudged : {"0.3,1e6,0\n", "0.1,nan,0\n0.3,1e6,0\n"}) {
    EXPECT_FALSE(against(unjudged).references.at(0).word != ReferenceWord::not_judged);
    EXPECT_EQ(against(unjudged).outcome, Outcome::failed);
  }
  EXPECT_THAT(complaint("# error = 1 %\nt [s],A.child.T_y [N m]\nnan,1\n"), HasSubstr("'nan' is not a number"));
  EXPECT_THAT(complaint("# error = 1 %\nt [s],any_bob.x [m]\n0,1\n"), HasSubstr("has no 'any_bob.x'"));
}

TEST_F(ReferenceTest, APercentageOfNothingAllowsWhatTheRunsLeaveOpen) {
  model_ = pendulum_model();  // no spring and no driver: tau is zero
  const Verdict verdict = verified();
  const auto outcome_with = [&](double tau) {
    Verdict judged = verdict;
    judge_reference(model_, read(fmt::format("# error = 0.01 %\nt [s],A.tau_1 [N m]\n0,{}\n", tau)), judged);
    return judged.outcome;
  };
  EXPECT_EQ(outcome_with(1e-17), Outcome::agree);
  EXPECT_EQ(outcome_with(1e-9), Outcome::differ);
}

/// The scale of the table would take the lever of the largest force for a torque that is twenty times less.
TEST_F(ReferenceTest, APercentageOfATorqueIsOfThatTorque) {
  Verdict verdict = verified();
  double peak = 0.0;
  for (const Sample& sample : verdict.trajectories[0]->samples) {
    peak = std::max(peak, sample.evaluation.joints[0].reaction[1].in_C.torque.norm());
  }
  judge_reference(model_, read("# error = 2 %\nt [s],A.child.T_y [N m]\n0,0\n"), verdict);
  EXPECT_DOUBLE_EQ(verdict.references.at(0).allowed, 0.02 * peak);
}

// Where the solvers say zero, or half of what was measured, a part of it would be an error that no source means.
TEST_F(ReferenceTest, APercentageIsOfTheLargerOfRunAndReference) {
  model_ = pendulum_model();  // no spring and no driver: tau is zero
  const Verdict verdict = verified();
  const auto judged = [&](const std::string& text) {
    Verdict judged = verdict;
    judge_reference(model_, read(text), judged);
    return judged;
  };
  const Verdict against_zero = judged("# error = 0.1 %\nt [s],A.tau_1 [N m]\n0,-14.867491\n0.2,3\n");
  EXPECT_EQ(against_zero.outcome, Outcome::differ);
  EXPECT_DOUBLE_EQ(against_zero.references.at(0).allowed, 0.014867491);
  // Components of one vector together, neither those of the other side nor torques.
  const std::string columns = "t [s],A.child.F_x [N],A.child.F_y [N],A.child.T_x [N m],A.parent.F_x [N]\n";
  const Verdict of_vector = judged("# error = 2 %\n" + columns + "0,300,1,1e6,1e7\n0.2,3e3,-4e3,0,0\n");
  EXPECT_DOUBLE_EQ(of_vector.references.at(0).allowed, 0.02 * 5e3);
  EXPECT_DOUBLE_EQ(of_vector.references.at(1).allowed, 0.02 * 5e3);
  EXPECT_DOUBLE_EQ(of_vector.references.at(2).allowed, 0.02 * 1e6);
  EXPECT_DOUBLE_EQ(of_vector.references.at(3).allowed, 0.02 * 1e7);
}

TEST_F(ReferenceTest, AMeasurementThatIsLargerByItsOwnErrorAgrees) {
  const Verdict verdict = verified();
  const std::vector<Sample>& samples = verdict.trajectories[0]->samples;
  const auto tau = [](const Sample& sample) { return sample.evaluation.joints[0].tau(0); };
  const Sample& at = *std::max_element(samples.begin(), samples.end(), [&](const Sample& one, const Sample& other) {
    return std::abs(tau(one)) < std::abs(tau(other));
  });
  const auto outcome_at = [&](double factor) {
    Verdict judged = verdict;
    const std::string row = fmt::format("{},{}", at.state.t, factor * tau(at));
    judge_reference(model_, read("# error = 20 %\nt [s],A.tau_1 [N m]\n" + row + "\n"), judged);
    return judged.outcome;
  };
  EXPECT_EQ(outcome_at(0.81), Outcome::agree);
  EXPECT_EQ(outcome_at(0.79), Outcome::differ);
  EXPECT_EQ(outcome_at(1.249), Outcome::agree) << "off by a fifth of the reference, by a quarter of the run";
  EXPECT_EQ(outcome_at(1.251), Outcome::differ);
}

TEST_F(ReferenceTest, TimesBeyondTheHorizonAreNotJudgedAndCounted) {
  Verdict verdict = verified();
  verdict.same_run.horizon = 0.2;
  const double value =
      verdict.trajectories[0]->samples[100].evaluation.joints[0].reaction_on(Side::child).in_C.force(1);
  const std::string head = "# error A.child.F_y = 0.01 N\nt [s],A.child.F_y [N]\n";
  Verdict judged = verdict;
  judge_reference(model_, read(fmt::format("{}0.2,{}\n0.3,1e6\n0.4,1e6\n", head, value)), judged);
  EXPECT_EQ(judged.outcome, Outcome::agree);
  ASSERT_FALSE(judged.notes.empty());
  EXPECT_THAT(judged.notes.back(), HasSubstr("reference: 2 of 3 times lie beyond t = 0.2 s"));
  judged = verdict;
  judge_reference(model_, read(head + "0.3,1e6\n"), judged);
  EXPECT_EQ(judged.outcome, Outcome::failed);
  EXPECT_FALSE(judged.references.at(0).word != ReferenceWord::not_judged);
  ASSERT_FALSE(judged.failures.empty());
  EXPECT_THAT(judged.failures.back(), HasSubstr("reference: nothing of it is judged"));
}

TEST_F(ReferenceTest, ATimeThatIsTakenForAnotherIsTold) {
  VerifyOptions options;
  options.samples = 300;  // of 0.4 s
  const Verdict verdict = verified(options);
  const auto notes_for = [&](const std::string& time) {
    Verdict judged = verdict;
    judge_reference(model_, read("# error = 1 %\nt [s],bob.e1 [1]\n" + time + ",0\n"), judged);
    return fmt::format("{}", fmt::join(judged.notes, "\n"));
  };
  EXPECT_THAT(notes_for("0.2"), Not(HasSubstr("is taken for")));
  EXPECT_THAT(notes_for("0.00133"), HasSubstr("t = 0.00133 s (line 3) is taken for the output time 0.00133333333 s"));
}

/// Of two columns that miss, the one that misses most, as its error allows, is named.
TEST_F(ReferenceTest, TheWorstColumnIsBlamedAndItsLineNamed) {
  Verdict verdict = verified();
  judge_reference(model_,
                  read("# error A.child.F_y = 1 N\n# error strut.child.F_x = 1 N\n"
                       "t [s],A.child.F_y [N],strut.child.F_x [N]\n0,100,1e4\n"),
                  verdict);
  ASSERT_TRUE(verdict.attribution);
  EXPECT_EQ(verdict.attribution->where, "force element strut");
  EXPECT_THAT(verdict.findings.at(1).what, HasSubstr("where it says 10000 N (line 4), error 1"));
}

TEST_F(ReferenceTest, AMissByAFactorNamesIt) {
  const Verdict verdict = verified();
  for (const double factor : {1e-3, 1e3}) {
    std::string text = "# error = 0.01 %\nt [s],A.child.F_y [N]\n";
    for (const std::size_t k : {0U, 70U, 130U, 200U}) {
      const Sample& sample = verdict.trajectories[0]->samples[k];
      const double stated = factor * sample.evaluation.joints[0].reaction[1].in_C.force(1);
      text += fmt::format("{},{:.5g}\n", sample.state.t, stated);  // as rounded as its error says
    }
    Verdict judged = verdict;
    judge_reference(model_, read(text), judged);
    const std::string& symptom = judged.findings.at(0).symptom;
    ASSERT_THAT(symptom, HasSubstr(" times as large: in other units?"));
    EXPECT_NEAR(std::stod(symptom.substr(symptom.find("it is ") + 6)), factor, 1e-3 * factor) << symptom;
  }
}

TEST_F(ReferenceTest, OneWrongNumberAmongZerosIsNoMatterOfUnits) {
  Verdict verdict = verified();
  std::string text = "# error A.child.F_z = 1e-9 N\nt [s],A.child.F_z [N]\n";
  for (auto& run : verdict.trajectories) {
    for (Sample& sample : run->samples) sample.evaluation.joints[0].reaction[1].in_C.force(2) = 0.0;
  }
  for (const std::size_t k : {0U, 70U, 130U, 200U}) {
    const double round_off = k == 70U ? 1e-14 : 0.0;
    for (auto& run : verdict.trajectories) run->samples[k].evaluation.joints[0].reaction[1].in_C.force(2) = round_off;
    text += fmt::format("{},{}\n", verdict.trajectories[0]->samples[k].state.t, k == 70U ? "1e-6" : "0");
  }
  judge_reference(model_, read(text), verdict);
  EXPECT_THAT(verdict.findings.at(0).symptom, Not(HasSubstr("times as large")));
}

TEST_F(ReferenceTest, AMissSaysWhichOtherColumnFits) {
  const Verdict verdict = verified();
  const auto hint_for = [&](const std::string& column, const std::function<double(const Sample&)>& said) {
    std::string text = fmt::format("# error = 0.01 %\nt [s],{}\n", column);
    for (const std::size_t k : {0U, 70U, 200U}) {
      const Sample& sample = verdict.trajectories[0]->samples[k];
      text += fmt::format("{},{}\n", 0.4 * static_cast<double>(k) / 200.0, said(sample));
    }
    Verdict judged = verdict;
    judge_reference(model_, read(text), judged);
    return judged.findings.empty() ? std::string("none") : judged.findings.front().symptom;
  };
  const std::string question = ": on another side, in other axes, or of the other sign?";
  EXPECT_THAT(hint_for("A.child.F_y [N]",
                       [](const Sample& sample) { return sample.evaluation.joints[0].reaction[1].in_global.force(1); }),
              HasSubstr("measured.csv; state that at its head"));
  EXPECT_THAT(hint_for("A.child.F_x [N]",
                       [](const Sample& sample) { return sample.evaluation.joints[0].reaction[0].in_C.force(2); }),
              HasSubstr("it agrees with A.parent.F_z" + question));
  EXPECT_THAT(hint_for("A.tau_1 [N m]", [](const Sample& sample) { return -sample.evaluation.joints[0].tau(0); }),
              HasSubstr("reference: measured.csv; it has the other sign"));
  EXPECT_THAT(hint_for("bob.omega_x [rad/s]", [](const Sample& sample) { return sample.state.bodies[1].omega(2); }),
              HasSubstr("it agrees with bob.omega_z" + question));
  EXPECT_EQ(hint_for("A.child.F_x [N]", [](const Sample& sample) { return 7.0 + sample.state.t; }),
            "reference: measured.csv");
}

TEST_F(ReferenceTest, IsARegularFile) {
  EXPECT_THROW((void)read_reference("/dev/zero", model_), InputError);
  EXPECT_THROW((void)read_reference(folder_.path(), model_), InputError);
}

TEST_F(ReferenceTest, TimesAreAsGoodAsTheyAreWritten) {
  RunOptions run;
  run.until = 1.0;
  run.samples = 300;
  EXPECT_NO_THROW(check_times(read("# error = 1 %\nt [s],A.child.F_y [N]\n0.0033333,1\n6.67e-3,1\n"), run));
  EXPECT_THROW(check_times(read("# error = 1 %\nt [s],A.child.F_y [N]\n0.0033300,1\n"), run), InputError);
  EXPECT_THROW(check_times(read("# error = 1 %\nt [s],A.child.F_y [N]\n0.003,1\n"), run), InputError);
}

TEST_F(ReferenceTest, TimesMustBeOutputTimes) {
  const Reference reference = read("# error = 1 %\nt [s],A.child.F_y [N]\n0.2,1\n0.2013,1\n");
  RunOptions run;
  run.until = 0.4;
  run.samples = 200;
  try {
    check_times(reference, run);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("measured.csv:4:1: error: reference: t = 0.2013 s is no output time of the run, "
                          "0.4 s in 200 intervals (the nearest is 0.202 s)"));
  }
}

}  // namespace
}  // namespace concord::compare
