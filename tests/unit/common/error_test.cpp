#include "common/error.h"

#include <gtest/gtest.h>

namespace concord {
namespace {

TEST(Error, DiagnosticSaysWhereAndWhat) {
  const Diagnostic complaint{{"crank.toml", 14, 9}, "mass must be positive, found -1 kg"};
  EXPECT_EQ(complaint.text(), "crank.toml:14:9: error: mass must be positive, found -1 kg");
}

TEST(Error, DiagnosticWithoutALineNamesTheFile) {
  const Diagnostic complaint{{"crank.toml", 0, 0}, "cannot be read"};
  EXPECT_EQ(complaint.text(), "crank.toml: error: cannot be read");
}

TEST(Error, InputErrorHoldsAllComplaintsInOrder) {
  const InputError error({{{"a.toml", 3, 1}, "first"}, {{"a.toml", 7, 5}, "second"}});
  EXPECT_STREQ(error.what(), "a.toml:3:1: error: first\na.toml:7:5: error: second");
  ASSERT_EQ(error.diagnostics().size(), 2U);
  EXPECT_EQ(error.diagnostics()[1].where.line, 7);
}

TEST(Error, InputErrorOfOneComplaint) {
  const InputError error({"a.toml", 2, 4}, "only");
  EXPECT_STREQ(error.what(), "a.toml:2:4: error: only");
}

}  // namespace
}  // namespace concord
