#include "tests/conformance/free_axes.h"

#include <gtest/gtest.h>

#include <ostream>

#include "compare/joint_check/sheet.h"

/// Joints of which the gap has a lever about some axes only, through the joint check: a component is said to be carried
/// if and only if it appears. All 64 sets of free axes pass by night.
namespace concord::joints {

/// How a failing test names its parameter.
void PrintTo(const JointType& type, std::ostream* stream) { *stream << type.name; }

}  // namespace concord::joints

namespace concord::compare::joint_check {
namespace {

using namespace joints;  // pages are written in its words

class FreeAxesConformance : public ::testing::TestWithParam<JointType> {};

INSTANTIATE_TEST_SUITE_P(Kin, FreeAxesConformance,
                         ::testing::Values(planar, with_free_axes({.x = true, .y = true}, Axes{}),
                                           with_free_axes({.x = true, .y = true}, Axes{true, true, true}),
                                           with_free_axes({.y = true, .z = true}, Axes{.x = true, .y = true})),
                         [](const auto& instance) { return instance.param.name; });

TEST_P(FreeAxesConformance, EveryPropertyHolds) {
  const Sheet sheet = check_joint(GetParam(), {.poses = {1, 2}});
  EXPECT_TRUE(sheet.holds()) << format_sheet(sheet);
}

}  // namespace
}  // namespace concord::compare::joint_check
