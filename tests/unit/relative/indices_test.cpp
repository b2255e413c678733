#include "relative/bodies/indices.h"

#include <gtest/gtest.h>

#include <type_traits>
#include <vector>

namespace concord::relative {
namespace {

/// A link's index taken for a joint's would read another joint's numbers, of which no test need tell.
TEST(Indices, OfOneKindAreNotTakenForAnother) {
  static_assert(!std::is_convertible_v<int, LinkIndex>);
  static_assert(!std::is_convertible_v<JointIndex, LinkIndex>);
  static_assert(!std::is_constructible_v<LinkIndex, JointIndex>);
  static_assert(!std::is_constructible_v<BodyIndex, LinkIndex>);
  static_assert(!std::is_assignable_v<LinkIndex&, int>);
  static_assert(std::is_constructible_v<LinkIndex, int>);
  static_assert(std::is_convertible_v<LinkIndex, int>);
  const std::vector<int> numbers{7, 8, 9};
  EXPECT_EQ(numbers[LinkIndex(2)], 9);
  EXPECT_TRUE(LinkIndex(2) == LinkIndex(2));
  EXPECT_FALSE(LinkIndex(2) == LinkIndex(1));
}

TEST(Indices, RangesVisitEachOnce) {
  std::vector<int> seen;
  for (const RowIndex row : upward<RowIndex>(3)) seen.push_back(row);
  for (const RowIndex row : downward<RowIndex>(3)) seen.push_back(row);
  for (const RowIndex row : upward<RowIndex>(0)) seen.push_back(row);
  for (const RowIndex row : downward<RowIndex>(0)) seen.push_back(row);
  EXPECT_EQ(seen, (std::vector<int>{0, 1, 2, 2, 1, 0}));
}

}  // namespace
}  // namespace concord::relative
