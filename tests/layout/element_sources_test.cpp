#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

namespace concord::layout {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::string in_small_letters(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// Every C++ source outside the tests that names the word, by its path in the project.
std::set<std::string> sources_that_name(const std::string& word) {
  const fs::path root = CONCORD_SOURCE;
  std::set<std::string> found;
  for (const char* folder : {"common", "cartesian", "relative", "compare"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".cpp" && extension != ".h") continue;
      if (in_small_letters(text_of(entry.path())).find(word) == std::string::npos) continue;
      found.insert(fs::relative(entry.path(), root).generic_string());
    }
  }
  return found;
}

/// A force element without regimes costs its page, its place among the kinds, and the clauses that its manual lists.
TEST(ElementSources, AreThoseOfTheManual) {
  const std::string manual = text_of(fs::path(CONCORD_SOURCE) / "common/elements/README.md");
  const std::set<std::string> found = sources_that_name("bushing");
  EXPECT_LE(found.size(), 8U);
  for (const std::string& source : found) {
    if (source == "common/elements/bushing.h" || source == "common/elements/force_element.h") continue;
    EXPECT_THAT(manual, ::testing::HasSubstr("`" + source + "`"));
  }
}

}  // namespace
}  // namespace concord::layout
