#include "tests/benchmarks/counts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "common/error.h"
#include "common/reading/text_file.h"
#include "compare/report/files.h"
#include "tests/unit/temporary_folder.h"

namespace concord::benchmarks {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string kBuild = "clang 14.0.6, Eigen 3.4.0";
const Accepted kAccepted{{kBuild, {{"car, info", {1000000, 0}}, {"crank by relative", {200000, 1000}}}},
                         {"gcc 12.2.0, Eigen 3.4.0", {{"car, info", {500, 0}}}}};

Judgement judged(const Counts& counted) { return judge(kAccepted, kBuild, counted); }

std::string refusal(const std::string& text) {
  try {
    parse_accepted(text, "counts.csv");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST(Counts, TextIsReadBackAndSorted) {
  const std::string text = format_accepted(kAccepted);
  EXPECT_EQ(parse_accepted(text, "counts.csv"), kAccepted);
  EXPECT_THAT(
      text, HasSubstr("build,\"clang 14.0.6, Eigen 3.4.0\"\n,\"car, info\",1000000,0\n,crank by relative,200000,1000\n"
                      "build,\"gcc 12.2.0"));
}

TEST(Counts, WrongLinesAreRefusedByPlace) {
  EXPECT_EQ(refusal("concord baseline,1\n"), "counts.csv:1:1: error: the first line must be 'concord counts,1'");
  EXPECT_EQ(refusal("concord counts,1\n,car,1,2\n"),
            "counts.csv:2:1: error: expected 'build,NAME' and then lines of ',job,instructions,evaluations'");
  EXPECT_EQ(refusal("concord counts,1\nbuild,x\n,car,1.5,2\n"), "counts.csv:3:1: error: expected a count, found '1.5'");
  EXPECT_EQ(refusal("concord counts,1\nbuild,x\n,car,1,2\n,car,1,2\n"),
            "counts.csv:4:1: error: 'car' stands there twice");
}

TEST(Counts, ARiseOfThreeHundredthsIsRed) {
  const Judgement judgement = judged({{"car, info", {1030000, 0}}, {"crank by relative", {205999, 1030}}});
  EXPECT_THAT(judgement.red, ElementsAre("car, info: instructions 1000000 -> 1030000 (+3.0 %)",
                                         "crank by relative: evaluations 1000 -> 1030 (+3.0 %)"));
  EXPECT_THAT(judgement.fallen, IsEmpty());
}

TEST(Counts, AFallOfThreeHundredthsIsToldAndNotRed) {
  const Judgement judgement = judged({{"car, info", {970000, 0}}, {"crank by relative", {194001, 971}}});
  EXPECT_THAT(judgement.red, IsEmpty());
  EXPECT_THAT(judgement.fallen, ElementsAre("car, info: instructions 1000000 -> 970000 (-3.0 %)"));
}

TEST(Counts, JobsThatAreMissingOnOneSideAreNamed) {
  const Judgement judgement = judged({{"car, info", {1000000, 0}}, {"ladder", {1, 1}}});
  EXPECT_THAT(judgement.red, ElementsAre("crank by relative: accepted, but no longer counted",
                                         "ladder: counted, but not accepted yet"));
}

TEST(Counts, AnotherBuildIsNotCompared) {
  const Judgement judgement = judge(kAccepted, "clang 15.0.0, Eigen 3.4.0", {{"car, info", {9000000, 0}}});
  EXPECT_FALSE(judgement.is_compared);
  EXPECT_THAT(judgement.red, IsEmpty());
  EXPECT_TRUE(judged({}).is_compared);
}

/// A folder as callgrind and the program leave it, and the file beside it.
class CountedFolder : public testing::Test {
 protected:
  void count(const std::string& instructions) {
    compare::write_file(folder / "evaluations", "car by relative,552\n");
    compare::write_file(
        folder / "profile.1",
        "desc: Trigger: Client Request: car by relative\n\nfn=(1) main\n16 7\n\ntotals: " + instructions + "\n");
    compare::write_file(folder / "profile", "desc: Trigger: Program termination\n\ntotals: 3\n");
  }
  int judge_it() { return judge_counts(folder, file, out); }

  compare::TemporaryFolder temporary;
  std::filesystem::path folder = temporary.path() / "counted";
  std::filesystem::path file = temporary.path() / "counts.csv";
  std::ostringstream out;
};

TEST_F(CountedFolder, IsComparedOnceAcceptedWithAReason) {
  count("1000");
  EXPECT_EQ(judge_it(), 77);
  EXPECT_THAT(out.str(), HasSubstr("not compared: " + file.string() + " holds no counts of " + build_of_program()));

  accept_counts(folder, file, "first\ncounts", out);
  EXPECT_EQ(judge_it(), 0);
  const std::string log = read_text_file(temporary.path() / "counts.log");
  EXPECT_THAT(log, HasSubstr("): first counts\n  car by relative: new: instructions 1000, evaluations 552\n"));

  count("1040");
  EXPECT_EQ(judge_it(), 1);
  EXPECT_THAT(out.str(), HasSubstr("RED car by relative: instructions 1000 -> 1040 (+4.0 %)\n"));
  accept_counts(folder, file, "the price of sturdier pivots", out);
  EXPECT_EQ(judge_it(), 0);
}

TEST_F(CountedFolder, LacksAProfile) {
  count("1000");
  std::filesystem::remove(folder / "profile.1");
  try {
    judge_it();
    FAIL() << "a job without a profile was taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("callgrind left no profile of 'car by relative'"));
  }
}

}  // namespace concord::benchmarks
