#include "common/reading/spelling.h"

#include <gtest/gtest.h>

namespace concord {
namespace {

TEST(Spelling, CountsTheEditsBetweenWords) {
  EXPECT_EQ(edit_distance("", ""), 0);
  EXPECT_EQ(edit_distance("mass", "mass"), 0);
  EXPECT_EQ(edit_distance("", "mass"), 4);
  EXPECT_EQ(edit_distance("mss", "mass"), 1);
  EXPECT_EQ(edit_distance("masss", "mass"), 1);
  EXPECT_EQ(edit_distance("mast", "mass"), 1);
  EXPECT_EQ(edit_distance("msas", "mass"), 1) << "neighbours swapped count as one edit";
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
}

TEST(Spelling, SuggestsTheNearestWordOrListsAll) {
  EXPECT_EQ(suggestion("tpye", {"name", "type"}, "keys"), "did you mean 'type'?");
  EXPECT_EQ(suggestion("colour", {"name", "type"}, "keys"), "known keys: name, type");
  EXPECT_EQ(suggestion("X", {"A", "B"}, "joints"), "known joints: A, B") << "names of one letter are all alike";
  EXPECT_EQ(suggestion("X", {}, "joints"), "there are no joints");
}

TEST(Spelling, KnowsWhatOtherProgramsCallAWord) {
  EXPECT_EQ(suggestion("prismatic", {"revolute", "translational"}, "types"), "did you mean 'translational'?");
  EXPECT_EQ(suggestion("sine", {"harmonic", "spline"}, "laws"), "did you mean 'harmonic'?");
  EXPECT_EQ(suggestion("local", {"body", "global"}, "axes"), "did you mean 'body'?");
  EXPECT_EQ(suggestion("table", {"tables", "chair"}, "bodies"), "did you mean 'tables'?") << "no law is asked for";
}

TEST(Spelling, JoinsNames) {
  EXPECT_EQ(join_names({"a", "b", "c"}), "a, b, c");
  EXPECT_EQ(join_names({}), "");
}

}  // namespace
}  // namespace concord
