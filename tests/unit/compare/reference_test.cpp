#include "compare/reference.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "compare/files.h"
#include "compare/table.h"
#include "compare/verify.h"
#include "fake_pendulum.h"
#include "temporary_folder.h"

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
  EXPECT_EQ(reference.columns[0].quantity, (Quantity{Kind::reaction, 0, Side::child, 4}));
  EXPECT_TRUE(reference.columns[0].is_relative);
  EXPECT_DOUBLE_EQ(reference.columns[0].error, 0.005);
  EXPECT_EQ(reference.columns[1].quantity, (Quantity{Kind::element, 0, Side::child, 0}));
  EXPECT_FALSE(reference.columns[1].is_relative);
  EXPECT_DOUBLE_EQ(reference.columns[1].error, 0.2);
  EXPECT_EQ(reference.times, (std::vector<double>{0.0, 0.2}));
  EXPECT_EQ(reference.columns[0].values, (std::vector<double>{1.5, 1.25}));
}

TEST_F(ReferenceTest, SaysWhereAndWhy) {
  EXPECT_EQ(
      complaint("# error = 1 %\nt [s],B.child.F_x [N]\n0,1\n"),
      "measured.csv:2:1: error: reference: the model has no 'B.child.F_x'; columns are called JOINT.child.F_x [N] "
      "... JOINT.parent.T_z [N m]");
  EXPECT_EQ(complaint("# error = 1 %\nt [s],A.child.F_x [kN]\n0,1\n"),
            "measured.csv:2:1: error: reference: column 'A.child.F_x [kN]': the unit must be said, [N]");
  EXPECT_THAT(complaint("t [s],A.child.F_x [N]\n0,1\n"), HasSubstr("'A.child.F_x' has no stated error"));
  EXPECT_THAT(complaint("# error = 1 %\nt [s],A.child.F_x [N]\n0,none\n"), HasSubstr(":3:1: error: reference: 'none'"));
  EXPECT_THAT(complaint("# error = 1 %\nt [s],A.child.F_x [N]\n0,1\n0,1\n"), HasSubstr("times must rise"));
  EXPECT_THAT(complaint("# error = 1 %\nt [s],A.child.F_x [N]\n0,1,2\n"), HasSubstr("3 numbers, the header has 2"));
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
