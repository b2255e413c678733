#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/unit/manual/pages.h"

/// How long what a person reads at one go may be: a page, a paragraph, a cell of a table.
namespace concord::manual {
namespace {

constexpr std::size_t kLongestPage = 2500;      // words
constexpr std::size_t kLongestParagraph = 120;  // words
constexpr std::size_t kLongestCell = 200;       // characters

std::vector<fs::path> all_pages() {
  std::vector<fs::path> pages{kRoot / "README.md"};
  for (const std::string folder : {".github", "common", "cartesian", "relative", "compare", "data", "tests"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      if (entry.path().extension() == ".md") pages.push_back(entry.path());
    }
  }
  return pages;
}

std::string name_of(const fs::path& page) { return fs::relative(page, kRoot).generic_string(); }

std::size_t words_of(const std::string& text) {
  std::istringstream words(text);
  std::size_t count = 0;
  for (std::string word; words >> word;) ++count;
  return count;
}

std::string without_blanks_around(const std::string& text) {
  const std::size_t first = text.find_first_not_of(' ');
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(' ') - first + 1);
}

/// A paragraph or an item of a list, with the line in which it begins; code, tables and headings are none.
struct Paragraph {
  std::size_t line = 0;
  std::string text;
};

std::vector<Paragraph> paragraphs_of(const std::vector<std::string>& lines) {
  static const std::regex item(R"(^ *([*+-]|[0-9]+\.) .*)");
  static const std::regex none(R"(^(\||#|<!|!\[|```).*)");
  std::vector<Paragraph> paragraphs;
  bool is_code = false;
  bool is_new = true;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const bool is_fence = lines[k].rfind("```", 0) == 0;
    if (is_fence) is_code = !is_code;
    if (is_code || is_fence || lines[k].empty() || std::regex_match(lines[k], none)) {
      is_new = true;
      continue;
    }
    if (is_new || std::regex_match(lines[k], item)) paragraphs.push_back({k + 1, ""});
    paragraphs.back().text += lines[k] + " ";
    is_new = false;
  }
  return paragraphs;
}

/// Of a row of a table, outside code blocks.
std::vector<std::string> trimmed_cells_of(const std::string& row) {
  std::vector<std::string> cells;
  std::istringstream in(row.substr(1));
  for (std::string cell; std::getline(in, cell, '|');) cells.push_back(without_blanks_around(cell));
  return cells;
}

TEST(PageLengths, PagesAreShort) {
  const std::set<std::string> may_be_longer{"common/THEORY.md", "cartesian/THEORY.md", "relative/THEORY.md",
                                            "tests/faults/README.md"};
  for (const fs::path& page : all_pages()) {
    if (may_be_longer.count(name_of(page)) != 0) continue;
    std::size_t words = 0;
    for (const std::string& line : lines_of(page)) words += words_of(line);
    EXPECT_LE(words, kLongestPage) << name_of(page) << ": give a part of it a page of its own";
  }
}

TEST(PageLengths, ParagraphsAreShort) {
  std::size_t paragraphs = 0;
  for (const fs::path& page : all_pages()) {
    for (const Paragraph& paragraph : paragraphs_of(lines_of(page))) {
      ++paragraphs;
      EXPECT_LE(words_of(paragraph.text), kLongestParagraph)
          << name_of(page) << ':' << paragraph.line << ": " << paragraph.text;
    }
  }
  EXPECT_GE(paragraphs, 500U);
}

TEST(PageLengths, CellsOfTablesAreShort) {
  std::size_t cells = 0;
  for (const fs::path& page : all_pages()) {
    std::size_t number = 0;
    bool is_code = false;
    for (const std::string& line : lines_of(page)) {
      ++number;
      if (line.rfind("```", 0) == 0) is_code = !is_code;
      if (is_code || line.rfind('|', 0) != 0) continue;
      for (const std::string& cell : trimmed_cells_of(line)) {
        ++cells;
        EXPECT_LE(cell.size(), kLongestCell) << name_of(page) << ':' << number << ": " << cell;
      }
    }
  }
  EXPECT_GE(cells, 1000U);
}

/// What the three tests above are made of, on a text that is known.
TEST(PageLengths, AreCounted) {
  const std::vector<Paragraph> found = paragraphs_of(
      {"# Heading", "One two", "three.", "* four", "  five", "```", "six seven", "```", "| eight |", "nine"});
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(words_of(found[0].text), 3U);
  EXPECT_EQ(words_of(found[1].text), 3U);
  EXPECT_EQ(found[2].line, 10U);
  EXPECT_EQ(trimmed_cells_of("| one | two three |"), (std::vector<std::string>{"one", "two three"}));
}

}  // namespace
}  // namespace concord::manual
