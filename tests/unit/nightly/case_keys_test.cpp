#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "common/reading/toml_document.h"
#include "compare/nightly/case_tables.h"

namespace concord::compare::nightly {
namespace {

using testing::HasSubstr;

/// What is said of a case with these keys; empty if nothing is.
std::string complaints(const std::string& text, Work work) {
  const toml::table root = parse_toml(text, "suite.toml");
  FileReading reading;
  reading.file = "suite.toml";
  const TableReader table(root, "case", case_keys(), reading);
  refuse_keys_without_meaning(table, work);
  try {
    reading.throw_if_any();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST(CaseKeys, AreRefusedWhereTheyMeanNothing) {
  EXPECT_THAT(
      complaints("until = 3", Work::joint),
      HasSubstr("suite.toml:1:9: error: case: 'until' means nothing to the work \"joint\", only to \"compare\""));
  EXPECT_THAT(complaints("name = \"x\"\nrtol = 1e-9", Work::statics), HasSubstr("suite.toml:2:8: error: case: 'rtol'"));
  EXPECT_THAT(complaints("poses = 3", Work::compare), HasSubstr("only to \"joint\""));
  EXPECT_THAT(complaints("accelerations = {}", Work::linearize), HasSubstr("only to \"inverse\""));
  EXPECT_THAT(complaints("sweep = { rtol = [1e-9] }", Work::invariance), HasSubstr("'rtol' means nothing"));
}

TEST(CaseKeys, AreTakenWhereTheyMeanSomething) {
  EXPECT_EQ(complaints("until = 3\nrtol = 1e-9\nsweep = { rtol = [1e-9] }\nneed = []", Work::compare), "");
  EXPECT_EQ(complaints("until = 3\nsweep = { cut = {} }", Work::invariance), "");
  EXPECT_EQ(complaints("at = \"equilibrium\"\nneed = []", Work::linearize), "");
  EXPECT_EQ(complaints("seed = 1\nfirst = 2\ncount = 3\nshares = 4\nstyle = \"mixed\"\nseconds = 5", Work::fuzz), "");
}

}  // namespace concord::compare::nightly
