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

TEST(Spelling, SuggestsAWordOnlyIfAtMostAThirdOfItsLettersIsWrong) {
  EXPECT_EQ(suggestion("fore", {"free", "from"}, "keys"), "known keys: free, from") << "2 of 4 letters";
  EXPECT_EQ(suggestion("mas", {"mass"}, "keys"), "did you mean 'mass'?") << "1 of 4";
  EXPECT_EQ(suggestion("stifnes", {"stiffness"}, "keys"), "did you mean 'stiffness'?") << "2 of 9";
  EXPECT_EQ(suggestion("sting", {"string"}, "keys"), "did you mean 'string'?") << "1 of 6";
  EXPECT_EQ(suggestion("color", {"floor"}, "keys"), "known keys: floor") << "2 of 5";
}

TEST(Spelling, KnowsPluralAndSingular) {
  EXPECT_TRUE(is_same_but_for_number("bodies", "body"));
  EXPECT_TRUE(is_same_but_for_number("body", "bodies"));
  EXPECT_TRUE(is_same_but_for_number("axis", "axes"));
  EXPECT_TRUE(is_same_but_for_number("masses", "mass"));
  EXPECT_TRUE(is_same_but_for_number("line_springs", "line_spring"));
  EXPECT_TRUE(is_same_but_for_number("run", "run"));
  EXPECT_FALSE(is_same_but_for_number("body", "bode"));
  EXPECT_FALSE(is_same_but_for_number("gas", "ga_s"));
  EXPECT_EQ(suggestion("axis", {"z", "axes"}, "keys"), "did you mean 'axes'?");
}

TEST(Spelling, TellsWhatConcordDoesNotHave) {
  const std::string of_contact =
      "concord has no contact between bodies: 'lower_stop' and 'upper_stop' in the 'spring' of a joint limit a "
      "coordinate, a [[tire]] stands on a [[road]]";
  EXPECT_EQ(help_with_word("contact", {"coupling", "joint"}, "keys"), of_contact);
  EXPECT_EQ(help_with_word("contacts", {"coupling", "joint"}, "keys"), of_contact) << "in any number";
  EXPECT_EQ(help_with_word("forces", {"force", "joint"}, "keys"), "did you mean 'force'?") << "the table has it";
  EXPECT_EQ(help_with_word("mu", {"friction"}, "keys"), "did you mean 'friction'?") << "a tire has it";
  EXPECT_EQ(help_with_word("tpye", {"name", "type"}, "keys"), "did you mean 'type'?");
  EXPECT_EQ(suggestion("friction", {"m_crank"}, "parameters"), "known parameters: m_crank") << "a name of the user's";
}

TEST(Spelling, JoinsNames) {
  EXPECT_EQ(join_names({"a", "b", "c"}), "a, b, c");
  EXPECT_EQ(join_names({}), "");
}

}  // namespace
}  // namespace concord
