#include "compare/report/whole_number.h"

#include <gtest/gtest.h>

namespace concord::compare {
namespace {

TEST(WholeNumberTest, TakesWhatFitsAndNothingElse) {
  for (const char* good : {"0", "7", "18446744073709551615"}) EXPECT_EQ(why_no_whole_number(good), "") << good;
  for (const char* bad : {"-1", "18446744073709551616", "1.5", "3x", "", " 3"}) {
    EXPECT_NE(why_no_whole_number(bad), "") << bad;
  }
}

TEST(WholeNumberTest, TakesNumbersWithinLimitsAndNaNIsNone) {
  for (const char* good : {"0.5", "1e4", "12"}) EXPECT_EQ(why_not_within(good, 0.5, 1e4), "") << good;
  for (const char* bad : {"0.4", "1.1e4", "nan", "-nan", "inf", "3x", "", " 3"}) {
    EXPECT_NE(why_not_within(bad, 0.5, 1e4), "") << bad;
  }
}

}  // namespace
}  // namespace concord::compare
