#include "compare/report/colours.h"

#include <gtest/gtest.h>

#include <sstream>

namespace concord::compare {
namespace {

TEST(Colours, OfVerdictsThatFillACellOrBeginALine) {
  EXPECT_EQ(in_colours("| A | agree   |\n| B |  differ |\n"),
            "| A | \033[32magree\033[0m   |\n| B |  \033[31mdiffer\033[0m |\n");
  EXPECT_EQ(in_colours("differ car: 3 of 4\n"), "\033[31mdiffer\033[0m car: 3 of 4\n");
  EXPECT_EQ(in_colours("| not unique |"), "| \033[33mnot unique\033[0m |");
}

TEST(Colours, OfNothingElse) {
  for (const char* text : {"| agree with A | x |\n", "both agree\n", "agreement 3\n", "| x |agree |\n", "agree", ""}) {
    EXPECT_EQ(in_colours(text), text);
  }
}

TEST(Colours, AreShownWhereTheConsoleDoes) {
  std::ostringstream out;
  EXPECT_EQ(shown({out, out}, "agree x"), "agree x");
  EXPECT_EQ(shown({out, out, false, true}, "agree x"), "\033[32magree\033[0m x");
}

}  // namespace
}  // namespace concord::compare
