#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>
#include <string>

#include "tests/layout/source_sizes.h"

namespace concord::layout {
namespace {

/// Sources outside the tests that name a word, in large letters or small.
std::set<std::string> sources_that_name(const std::string& word) {
  std::set<std::string> found;
  for (auto& [path, text] : sources(CONCORD_SOURCE)) {
    std::string small = text;
    std::transform(small.begin(), small.end(), small.begin(), [](unsigned char c) { return std::tolower(c); });
    if (small.find(word) != std::string::npos) found.insert(path);
  }
  return found;
}

/// A force element without regimes costs its page, its place among the kinds, and the clauses that its manual lists.
TEST(ElementSources, AreThoseOfTheManual) {
  const std::string manual = text_of(std::filesystem::path(CONCORD_SOURCE) / "common/elements/README.md");
  const std::set<std::string> found = sources_that_name("bushing");
  EXPECT_LE(found.size(), 8U);
  for (const std::string& source : found) {
    if (source == "common/elements/bushing.h" || source == "common/elements/force_element.h") continue;
    EXPECT_THAT(manual, ::testing::HasSubstr("`" + source + "`"));
  }
}

}  // namespace
}  // namespace concord::layout
