#include "tests/conformance/free_axes.h"

#include <gtest/gtest.h>

#include <ostream>

#include "compare/joint_check/sheet.h"

/// Every set of axes that a joint can leave free, through the joint check.
namespace concord::joints {

/// How a failing test names its parameter.
void PrintTo(const JointType& type, std::ostream* stream) { *stream << type.name; }

}  // namespace concord::joints

namespace concord::compare::joint_check {
namespace {

class EverySetOfFreeAxes : public ::testing::TestWithParam<joints::JointType> {};

INSTANTIATE_TEST_SUITE_P(All, EverySetOfFreeAxes, ::testing::ValuesIn(joints::with_any_free_axes()),
                         [](const auto& instance) { return instance.param.name; });

TEST_P(EverySetOfFreeAxes, HoldsEveryProperty) {
  const Sheet sheet = check_joint(GetParam(), {.poses = {1, 2, 3}});
  EXPECT_GE(sheet.looked(), 25);
  EXPECT_TRUE(sheet.holds()) << format_sheet(sheet);
}

}  // namespace
}  // namespace concord::compare::joint_check
