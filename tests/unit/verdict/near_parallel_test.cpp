#include "compare/verdict/near_parallel.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "common/reading/model_file.h"

namespace concord::compare {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

/// Two links on ground, the second one's hinge with its own axis.
Model two_hinges(const std::string& type, const std::string& axis_of_second) {
  return parse_model(fmt::format(R"toml(format = 1
[[body]]
name = "crank"
mass = 1
inertia = [1, 1, 1]
[[body]]
name = "rocker"
mass = 1
inertia = [1, 1, 1]
[[joint]]
name = "A"
type = "{}"
parent = {{ body = "ground", z = [1, 2, -2], x = [0, 1, 1] }}
child = {{ body = "crank" }}
[[joint]]
name = "D"
type = "revolute"
parent = {{ body = "ground", point = [1, 0, 0], z = {}, x = [0, 1, 1] }}
child = {{ body = "rocker" }}
[[joint]]
name = "rod"
type = "distance"
length = 0.9
parent = {{ body = "crank", point = [0, 0.3, 0] }}
child = {{ body = "rocker", point = [0, 0.4, 0] }}
)toml",
                                 type, axis_of_second),
                     "two_hinges.toml");
}

TEST(NearParallel, NamesHingesWhoseAxesWereRounded) {
  EXPECT_THAT(note_on_near_parallel_axes(two_hinges("revolute", "[1.000003, 2, -2]")),
              AllOf(HasSubstr("on ground"), HasSubstr("A and D"), HasSubstr("9.4e-07 rad")));
  EXPECT_THAT(note_on_near_parallel_axes(two_hinges("cylindrical", "[-1.000003, -2, 2]")), HasSubstr("9.4e-07 rad"));
}

TEST(NearParallel, SaysNothingOfAxesThatAreParallelOrAslant) {
  EXPECT_THAT(note_on_near_parallel_axes(two_hinges("revolute", "[1, 2, -2]")), IsEmpty());
  EXPECT_THAT(note_on_near_parallel_axes(two_hinges("revolute", "[0.1, 0.2, -0.2]")), IsEmpty());
  EXPECT_THAT(note_on_near_parallel_axes(two_hinges("revolute", "[1.01, 2, -2]")), IsEmpty());
  EXPECT_THAT(note_on_near_parallel_axes(two_hinges("spherical", "[1.000003, 2, -2]")), IsEmpty());
}

TEST(NearParallel, SaysNothingOfTreesAndOfMachinesThatDriversMove) {
  Model tree = two_hinges("revolute", "[1.000003, 2, -2]");
  tree.joints.pop_back();
  EXPECT_THAT(note_on_near_parallel_axes(tree), IsEmpty());
  Model driven = two_hinges("revolute", "[1.000003, 2, -2]");
  driven.joints[0].drivers.push_back({0, ConstantSpeed{0.0, 1.0}});
  EXPECT_THAT(note_on_near_parallel_axes(driven), IsEmpty());
}

TEST(NearParallel, SpeaksBesideTheReasonOfARefusal) {
  const StartNotFound refusal({"two_hinges.toml", 7, 1}, "nothing closes");
  EXPECT_STREQ(explained(refusal, two_hinges("revolute", "[1, 2, -2]")).what(), refusal.what());
  EXPECT_THAT(
      explained(refusal, two_hinges("revolute", "[1.000003, 2, -2]")).what(),
      AllOf(HasSubstr("two_hinges.toml:7:1: error: nothing closes; on ground the axes"), HasSubstr("all digits")));
}

}  // namespace
}  // namespace concord::compare
