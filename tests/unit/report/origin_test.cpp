#include "compare/report/origin.h"

#include <gtest/gtest.h>

namespace concord::compare {
namespace {

/// Finds two builds of changed sources that pass for one program, whose results --resume would mix.
TEST(Origins, BuildsOfChangedSourcesAreToldApart) {
  EXPECT_EQ(tell_builds_apart("3f97bf0c1a2b", 1), "3f97bf0c1a2b");
  EXPECT_EQ(tell_builds_apart("3f97bf0c1a2b-dirty", 0x12), "3f97bf0c1a2b-dirty.00000012");
  EXPECT_NE(tell_builds_apart("unknown", 1), tell_builds_apart("unknown", 2));
  EXPECT_EQ(origin_of_program("3f97bf0c1a2b-dirty").commit, "3f97bf0c1a2b-dirty");  // as the user says
  EXPECT_FALSE(origin_of_program().commit.ends_with("-dirty"));
}

}  // namespace
}  // namespace concord::compare
