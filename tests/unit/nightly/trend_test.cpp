#include "compare/nightly/trend.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"

namespace concord::compare::nightly {
namespace {

using testing::HasSubstr;

Entry night(long id, double digits, const std::string& commit) {
  Entry entry;
  entry.night.id = id;
  entry.night.origin.commit = commit;
  entry.result.id = "crank";
  entry.result.ending = Ending::agree;
  for (const char* name : {"A, F_x", "B, F_x"}) {
    Component& one = entry.result.components.emplace_back();
    one.name = name;
    one.same_run = name[0] == 'A' ? digits : 7.0;
  }
  return entry;
}

}  // namespace

TEST(Sparkline, SpansItsValues) {
  EXPECT_EQ(sparkline({1.0, 2.0, std::nullopt, 8.0}), "▁▂ █");
  EXPECT_EQ(sparkline({3.0, 3.0}), "▄▄");
  EXPECT_EQ(sparkline({}), "");
}

TEST(Trend, StepIsToldWithTheCommitsBeforeAndAfter) {
  const std::vector<Entry> nights{night(3, 6.1, "ccc"), night(2, 9.0, "bbb"), night(1, 9.1, "aaa")};
  const std::string text = format_trend("crank", nights, "A", {});
  EXPECT_THAT(text, HasSubstr("crank, A, F_x: 3 nights"));
  EXPECT_THAT(text, HasSubstr("worse in night 3: A, F_x, same run: 9.0 -> 6.1; commit bbb before, ccc after"));
  EXPECT_THAT(text, HasSubstr("██▁ 9.1 -> 6.1"));
  EXPECT_THAT(format_trend("crank", nights, "B", {}), HasSubstr("no steps"));
  EXPECT_THROW(format_trend("crank", nights, "C", {}), InputError);
}

}  // namespace concord::compare::nightly
