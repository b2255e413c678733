#include <gtest/gtest.h>

#include <ostream>

#include "common/joints/catalogue.h"
#include "compare/joint_check/sheet.h"

/// Every type of the catalogue through the joint check: a new type is tested here by standing in the catalogue.
namespace concord::joints {

/// How a failing test names its parameter.
void PrintTo(const JointType* type, std::ostream* stream) { *stream << type->name; }

}  // namespace concord::joints

namespace concord::compare::joint_check {
namespace {

class JointConformance : public ::testing::TestWithParam<const JointType*> {};

INSTANTIATE_TEST_SUITE_P(Catalogue, JointConformance, ::testing::ValuesIn(joints::catalogue()),
                         [](const auto& instance) { return instance.param->name; });

TEST_P(JointConformance, EveryPropertyHolds) {
  SheetOptions options;
  for (int pose = 0; pose < 20; ++pose) options.poses.push_back(pose);
  const Sheet sheet = check_joint(*GetParam(), options);
  EXPECT_GE(sheet.looked(), 30);
  EXPECT_TRUE(sheet.holds()) << format_sheet(sheet);
}

}  // namespace
}  // namespace concord::compare::joint_check
