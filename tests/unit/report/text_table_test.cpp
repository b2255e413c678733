#include "compare/report/text_table.h"

#include <gtest/gtest.h>

namespace concord::compare {
namespace {

TEST(TextTable, AlignsColumns) {
  EXPECT_EQ(format_table({{"joint", "digits"}, {"A", "9.5"}, {"hinge", "12.0"}}, {false, true}),
            "| joint | digits |\n"
            "|-------|-------:|\n"
            "| A     |    9.5 |\n"
            "| hinge |   12.0 |\n");
}

TEST(TextTable, TakesNoCharacterOfATextForItsOwn) {
  EXPECT_EQ(format_table({{"note"}, {"a | b"}, {"c\nd"}}, {false}),
            "| note   |\n"
            "|--------|\n"
            "| a \\| b |\n"
            "| c d    |\n");
}

}  // namespace
}  // namespace concord::compare
