#include "compare/audit/digits.h"

#include <gtest/gtest.h>

#include <limits>

namespace concord::compare {
namespace {

TEST(DigitsTest, CountsMatchingDigits) {
  EXPECT_NEAR(matching_digits(1e-7, 10.0), 8.0, 1e-12);
  EXPECT_NEAR(matching_digits(-2.0, 200.0), 2.0, 1e-12);
}

TEST(DigitsTest, StaysBetweenZeroAndSixteen) {
  EXPECT_EQ(matching_digits(1e-30, 1.0), 16.0);
  EXPECT_EQ(matching_digits(5.0, 1.0), 0.0);
}

TEST(DigitsTest, NoDifferenceNeedsNoScale) { EXPECT_EQ(matching_digits(0.0, 0.0), 16.0); }

TEST(DigitsTest, ADifferenceWithoutScaleOrWithoutNumberIsZeroDigits) {
  EXPECT_EQ(matching_digits(1e-20, 0.0), 0.0);
  EXPECT_EQ(matching_digits(std::numeric_limits<double>::quiet_NaN(), 1.0), 0.0);
  EXPECT_EQ(matching_digits(std::numeric_limits<double>::infinity(), 1.0), 0.0);
}

TEST(DigitsTest, PrintsNoMoreThanThereIs) {
  EXPECT_EQ(format_digits(11.99), "11.9");
  EXPECT_EQ(format_digits(0.04), "0.0");
}

TEST(DigitsTest, APartBeyondTenTimesIsNoNumberToRead) {
  EXPECT_EQ(format_percent(0.05549, 1), "+5.5 %");
  EXPECT_EQ(format_percent(-0.5, 0), "-50 %");
  EXPECT_EQ(format_percent(10.0, 1), "+1000.0 %");
  EXPECT_EQ(format_percent(10.1, 1), "more than +1000 %");
  EXPECT_EQ(format_percent(-6.0e40, 1), "less than -1000 %");
  EXPECT_EQ(format_percent(std::numeric_limits<double>::infinity(), 1), "more than +1000 %");
}

}  // namespace
}  // namespace concord::compare
