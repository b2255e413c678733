#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/reading/model_file.h"
#include "common/reading/modes_file.h"

/// The manual of the file format, data/README.md and data/format: every TOML block is either quoted from a file that is
/// named above it by `<!-- from FILE -->` and stands there verbatim, or a whole model or modes file that the reader
/// accepts.
namespace concord {
namespace {

namespace fs = std::filesystem;

const fs::path kData = CONCORD_DATA;

struct Excerpt {
  std::string page;
  std::string source;  // relative to data/; empty for a whole file
  std::string text;
};

std::string text_of(const fs::path& path) {
  std::ifstream stream(path);
  EXPECT_TRUE(stream.good()) << path;
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::vector<fs::path> format_pages() {
  std::vector<fs::path> pages{kData / "README.md"};
  for (const auto& entry : fs::directory_iterator(kData / "format")) pages.push_back(entry.path());
  return pages;
}

/// FILE of `<!-- from FILE -->`; empty for any other line.
std::string source_named_in(const std::string& line) {
  const std::string begin = "<!-- from ";
  const std::string end = " -->";
  if (!line.starts_with(begin) || !line.ends_with(end)) return "";
  return line.substr(begin.size(), line.size() - begin.size() - end.size());
}

void append_excerpts(const fs::path& page, std::vector<Excerpt>& excerpts) {
  std::istringstream lines(text_of(page));
  std::string above;
  bool is_inside = false;
  for (std::string line; std::getline(lines, line); above = line) {
    if (line.starts_with("```")) {
      is_inside = line == "```toml";
      if (is_inside) excerpts.push_back({page.filename().string(), source_named_in(above), ""});
    } else if (is_inside) {
      excerpts.back().text += line + "\n";
    }
  }
}

std::vector<Excerpt> all_excerpts() {
  std::vector<Excerpt> excerpts;
  for (const fs::path& page : format_pages()) append_excerpts(page, excerpts);
  return excerpts;
}

/// Reads it as a file of the folder data/; throws InputError.
void read_whole_file(const Excerpt& excerpt) {
  const fs::path file = kData / excerpt.page;
  if (excerpt.text.find("[[body]]") != std::string::npos) {
    EXPECT_GE(parse_model(excerpt.text, file).bodies.size(), 2U);
  } else {
    EXPECT_GE(parse_modes(excerpt.text, file).n_modes(), 1);
  }
}

TEST(FormatPages, EveryExcerptStandsInTheFileThatItNames) {
  int quoted = 0;
  for (const Excerpt& excerpt : all_excerpts()) {
    if (excerpt.source.empty()) continue;
    ++quoted;
    const bool is_there = text_of(kData / excerpt.source).find(excerpt.text) != std::string::npos;
    EXPECT_TRUE(is_there) << excerpt.page << ": not in data/" << excerpt.source << ":\n" << excerpt.text;
  }
  EXPECT_GE(quoted, 10);
}

TEST(FormatPages, EveryOtherExampleIsReadWithoutAComplaint) {
  int whole = 0;
  for (const Excerpt& excerpt : all_excerpts()) {
    if (!excerpt.source.empty()) continue;
    ++whole;
    EXPECT_NO_THROW(read_whole_file(excerpt)) << excerpt.page << ":\n" << excerpt.text;
  }
  EXPECT_GE(whole, 2);
}

TEST(FormatPages, EveryModelOfTheTutorialIsRead) {
  int models = 0;
  for (const auto& entry : fs::directory_iterator(kData / "tutorial")) {
    ++models;
    EXPECT_NO_THROW(EXPECT_GE(read_model(entry.path()).bodies.size(), 2U)) << entry.path();
  }
  EXPECT_EQ(models, 5);
}

}  // namespace
}  // namespace concord
