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

TEST(WholeNumberTest, SaysOfACountWhatIsWrongWithIt) {
  for (const char* good : {"1", "+5", "1000"}) EXPECT_EQ(why_no_count(good, 1, 1000), "") << good;
  EXPECT_EQ(why_no_count("1.5", 1, 1000), "expected a whole number from 1 to 1000, found '1.5'");
  for (const char* bad : {"0", "1001", "-3", "+-3", "++3", "+", "1e3", "99999999999999999999"}) {
    EXPECT_NE(why_no_count(bad, 1, 1000), "") << bad;
  }
}

TEST(WholeNumberTest, TakesNumbersWithinLimitsAndNaNIsNone) {
  for (const char* good : {"0.5", "1e4", "12", "+5", "+.7"}) EXPECT_EQ(why_not_within(good, 0.5, 1e4), "") << good;
  for (const char* bad : {"0.4", "1.1e4", "nan", "-nan", "inf", "3x", "", " 3"}) {
    EXPECT_NE(why_not_within(bad, 0.5, 1e4), "") << bad;
  }
}

}  // namespace
}  // namespace concord::compare
