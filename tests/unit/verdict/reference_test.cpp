#include "compare/verdict/reference.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <functional>

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

TEST_F(ReferenceTest, ASpreadsheetsMarkIsNoPartOfTheFirstColumn) {
  EXPECT_EQ(read("\xEF\xBB\xBFt [s],A.child.T_y [N m]\n# error = 0.5 %\n0,1.5\n").columns.size(), 1U);
}

TEST_F(ReferenceTest, SaysWhereAndWhy) {
  EXPECT_EQ(
      complaint("# error = 1 %\nt [s],B.child.F_x [N]\n0,1\n"),
      "measured.csv:2:1: error: reference: the model has no 'B.child.F_x'; columns are called JOINT.child.F_x [N] "
      "... JOINT.parent.T_z [N m], and as in all our result files");
  EXPECT_EQ(complaint("# error = 1 %\nt [s],A.child.F_x [kN]\n0,1\n"),
            "measured.csv:2:1: error: reference: column 'A.child.F_x [kN]': its unit must stand behind it: [N]");
  EXPECT_THAT(complaint("t [s],A.child.F_x [N]\n0,1\n"), HasSubstr("'A.child.F_x' has no stated error"));
  EXPECT_THAT(complaint("# error = 1 %\nt [s],A.child.F_x [N]\n0,none\n"), HasSubstr(":3:1: error: reference: 'none'"));
  EXPECT_THAT(complaint("# error = 1 %\nt [s],A.child.F_x [N]\n0,1\n0,1\n"), HasSubstr("times must rise"));
  EXPECT_THAT(complaint("# error = 1 %\nt [s],A.child.F_x [N]\n0,1,2\n"), HasSubstr("3 numbers, the header has 2"));
  EXPECT_THAT(complaint("# error = 1 %\nt [s],A.child.F_x [N],A.child.F_x [N]\n0,1,2\n"),
              HasSubstr("column 'A.child.F_x' stands there twice"));
  EXPECT_THAT(complaint("# error = 1 N\nt [s],A.child.F_x [N]\n0,1\n"), HasSubstr("must be in %"));
  EXPECT_THAT(complaint("# error A.child.F_x = 1 N m\nt [s],A.child.F_x [N]\n0,1\n"),
              HasSubstr("the error of 'A.child.F_x' is in N m, the column in N"));
}

TEST_F(ReferenceTest, BothSolversAreHeldAgainstItWithinItsStatedError) {
  FakePendulum cartesian(model_, "cartesian");
  FakePendulum relative(model_, "relative");
  Verdict verdict = verify(model_, cartesian, relative, {});
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
  EXPECT_TRUE(good.references.at(0).agrees);
  EXPECT_NEAR(good.references[0].differences[0], 0.009, 1e-12);
  const Verdict bad = against(value + 0.011);
  EXPECT_EQ(bad.outcome, Outcome::differ);
  EXPECT_THAT(bad.findings.at(0).what, HasSubstr("joint A on bob, F_y, against the reference: off by 0.011"));
  EXPECT_THAT(format_verdict(model_, bad, false), HasSubstr("| joint A on bob       | F_y       |"));
  EXPECT_THAT(format_verdict(model_, bad, false), HasSubstr("not climbed: reference"));
}

TEST_F(ReferenceTest, TakesEveryColumnOfOurOwnFiles) {
  FakePendulum cartesian(model_, "cartesian");
  FakePendulum relative(model_, "relative");
  const Verdict verdict = verify(model_, cartesian, relative, {});
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
      EXPECT_TRUE(good.references.at(0).agrees) << column.name;
      const Verdict bad = judged_with(value + 1.1e-3 * (value < 0.0 ? -1.0 : 1.0));
      EXPECT_FALSE(bad.references.at(0).agrees) << column.name;
      EXPECT_EQ(bad.outcome, bad.references[0].is_judged ? Outcome::differ : Outcome::agree) << column.name;
      EXPECT_FALSE(good.references[0].of.empty()) << column.name;
      ++tried;
    }
  }
  EXPECT_EQ(tried, 20U + 13U + 30U + 66U);
}

TEST_F(ReferenceTest, ErrorsInPercentOfMotionsAreOfThePeakOfTheirVector) {
  FakePendulum cartesian(model_, "cartesian");
  FakePendulum relative(model_, "relative");
  Verdict verdict = verify(model_, cartesian, relative, {});
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

TEST_F(ReferenceTest, EulerParametersMayHaveEitherSign) {
  FakePendulum cartesian(model_, "cartesian");
  FakePendulum relative(model_, "relative");
  Verdict verdict = verify(model_, cartesian, relative, {});
  const double e2 = verdict.trajectories[0]->samples[0].state.bodies[1].p(2);
  judge_reference(model_, read(fmt::format("# error = 0.001 %\nt [s],bob.e2 [1]\n0,{}\n", -e2)), verdict);
  EXPECT_TRUE(verdict.references.at(0).agrees);
}

TEST_F(ReferenceTest, AMissSaysWhichOtherColumnFits) {
  FakePendulum cartesian(model_, "cartesian");
  FakePendulum relative(model_, "relative");
  const Verdict verdict = verify(model_, cartesian, relative, {});
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
              HasSubstr("measured.csv; it agrees with A.child.global.F_y" + question));
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
                          "0.4 s in 200 intervals"));
  }
}

}  // namespace
}  // namespace concord::compare
