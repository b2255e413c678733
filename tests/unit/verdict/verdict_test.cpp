#include "compare/verdict/verdict.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace concord::compare {
namespace {

TEST(VerdictTest, ExitCodes) {
  EXPECT_EQ(exit_code(Outcome::agree), 0);
  EXPECT_EQ(exit_code(Outcome::differ), 1);
  EXPECT_EQ(exit_code(Outcome::failed), 3);
}

TEST(VerdictTest, Words) {
  EXPECT_EQ(to_string(Outcome::failed), "failed");
  EXPECT_EQ(to_string(Outcome::differ), "differ");
  EXPECT_EQ(to_string(Judgement::not_judged), "not judged");
  EXPECT_EQ(to_string(Judgement::agree), "agree");
}

TEST(VerdictTest, LeavesOutWhatHasBeenSaid) {
  std::vector<std::string> lines{"same run: cartesian: it locks", "relative: it locks", "cartesian: it locks",
                                 "relative: it locks", "it locks"};
  leave_out_repeated(lines);
  EXPECT_EQ(lines, (std::vector<std::string>{"same run: cartesian: it locks", "relative: it locks"}));
}

TEST(VerdictTest, NothingFoundIsNotAgreement) { EXPECT_EQ(Verdict{}.outcome, Outcome::failed); }

}  // namespace
}  // namespace concord::compare
