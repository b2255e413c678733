#include "compare/page/thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace concord::compare::page {
namespace {

TEST(Thinning, FewSamplesStayAsTheyAre) {
  const Bins bins(5, 10);
  EXPECT_FALSE(bins.thins());
  EXPECT_EQ(thin(bins, [](std::size_t k) { return 2.0 * static_cast<double>(k); }),
            (std::vector<double>{0, 2, 4, 6, 8}));
  EXPECT_EQ(thin_times(bins, {0, 1, 2, 3, 4}), (std::vector<double>{0, 1, 2, 3, 4}));
}

TEST(Thinning, NoPeakIsLostHoweverFewThePoints) {
  const auto curve = [](std::size_t k) {
    return k == 617 ? 5.0 : k == 84 ? -7.0 : std::sin(0.01 * static_cast<double>(k));
  };
  for (const std::size_t points : {2U, 10U, 100U}) {
    const Bins bins(1000, points);
    const std::vector<double> found = thin(bins, curve);
    ASSERT_LE(found.size(), points);
    EXPECT_EQ(*std::max_element(found.begin(), found.end()), 5.0);
    EXPECT_EQ(*std::min_element(found.begin(), found.end()), -7.0);
    const std::vector<double> sizes = largest_sizes(bins, curve);
    EXPECT_EQ(*std::max_element(sizes.begin(), sizes.end()), 7.0);
  }
}

TEST(Thinning, OfABinComesFirstWhatComesFirst) {
  const Bins bins(4, 2);
  EXPECT_EQ(thin(bins, [](std::size_t k) { return -static_cast<double>(k); }), (std::vector<double>{0, -3}));
  EXPECT_EQ(thin(bins, [](std::size_t k) { return static_cast<double>(k); }), (std::vector<double>{0, 3}));
}

TEST(Thinning, WhatIsNoNumberIsLeftOut) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const Bins bins(4, 2);
  EXPECT_EQ(thin(bins, [&](std::size_t k) { return k == 1 ? 3.0 : none; }), (std::vector<double>{3, 3}));
  EXPECT_TRUE(std::isnan(thin(bins, [&](std::size_t) { return none; })[0]));
}

}  // namespace
}  // namespace concord::compare::page
