#include "cartesian/bodies/indices.h"

#include <gtest/gtest.h>

#include <type_traits>
#include <vector>

#include "cartesian/bodies/layout.h"

namespace concord::cartesian {
namespace {

/// Whether one thing can be had for another, even where it is said that it should.
template <class To, class From>
constexpr bool becomes = std::is_constructible_v<To, From> || std::is_assignable_v<To&, From>;

template <class Things, class At>
concept Finds = requires(const Things& things, At at) {
  things[at];
};
template <class Thing, class At>
concept Picks = requires(const std::vector<Thing>& stated, At at) {
  pick(stated, at);
};
template <class At>
concept IsABodyOfALayout = requires(const Layout& layout, VecX q, At at) {
  layout.r(q, at);
};

/// A body's index taken for a joint's would read another joint's numbers, of which no test need tell.
TEST(Indices, OfOneKindAreTakenForNoOther) {
  static_assert(!becomes<JointIndex, BodyIndex> && !becomes<BodyIndex, JointIndex>);
  static_assert(!becomes<JointIndex, RowIndex> && !becomes<BodyIndex, RowIndex> && !becomes<RowIndex, BodyIndex>);
  static_assert(!becomes<AppliedForceIndex, ElementIndex> && !becomes<CouplingIndex, JointIndex>);
  static_assert(!std::is_convertible_v<int, JointIndex> && !std::is_convertible_v<JointIndex, int>);
  static_assert(!std::is_assignable_v<JointIndex&, int>);
  static_assert(IsABodyOfALayout<BodyIndex> && !IsABodyOfALayout<JointIndex> && !IsABodyOfALayout<RowIndex>);
  static_assert(!IsABodyOfALayout<int>);
  EXPECT_EQ(JointIndex(2), JointIndex(2));
  EXPECT_LT(JointIndex(1), JointIndex(2));
}

TEST(Indices, FindInTablesAndInTheModelWhatIsOfTheirKind) {
  static_assert(Finds<ByBody<int>, BodyIndex> && !Finds<ByBody<int>, JointIndex> && !Finds<ByBody<int>, int>);
  static_assert(Picks<Joint, JointIndex> && !Picks<Joint, BodyIndex> && !Picks<Joint, int>);
  ByJoint<double> table;
  EXPECT_EQ(table.add(0.5), JointIndex(0));
  EXPECT_EQ(table.add(1.5), JointIndex(1));
  EXPECT_EQ(table[JointIndex(1)], 1.5);
  std::vector<Joint> joints(2);
  joints[1].name = "A";
  EXPECT_EQ(pick(joints, JointIndex(1)).name, "A");
}

TEST(Indices, RangesVisitEachOnce) {
  std::vector<int> seen;
  for (const RowIndex row : RowRange(RowIndex(3) + 1, 2)) seen.push_back(row.value);
  for (const RowIndex row : RowRange(RowIndex(3), 0)) seen.push_back(row.value);
  for (const JointIndex k : ByJoint<int>(2).indices()) seen.push_back(k.value);
  EXPECT_EQ(seen, (std::vector<int>{4, 5, 0, 1}));
  static_assert(is_ground(BodyIndex(0)) && !is_ground(BodyIndex(1)));
}

/// An index costs what a number costs.
TEST(Indices, AreAsSmallAsNumbers) {
  static_assert(sizeof(RowIndex) == sizeof(int));
  static_assert(std::is_trivially_copyable_v<BodyIndex> && std::is_trivially_destructible_v<BodyIndex>);
}

}  // namespace
}  // namespace concord::cartesian
