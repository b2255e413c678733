#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/unit/manual/pages.h"

/// The theory manual: its equations are numbered, the sources cite the numbers, and the READMEs lead from a number to
/// its function. None of the three may lose touch with the others.
namespace concord::manual {
namespace {

/// A page defines its equations by \tag{C12} and everybody cites them as (C12).
struct Page {
  char letter;
  std::string folder;
};
const std::vector<Page> kPages{{'S', "common"}, {'C', "cartesian"}, {'R', "relative"}};

/// Lines between a citation and the name of its function: a comment and the first lines of a body.
constexpr int kNear = 12;

std::vector<std::string> citations(const std::string& line) {
  static const std::regex pattern(R"(\(([SCR][0-9]+)\))");
  if (line.find('(') == std::string::npos) return {};  // most lines; the rest is what takes time
  return all_matches(line, pattern);
}

/// The numbers of a page in its order.
std::vector<std::string> definitions(const Page& page) {
  static const std::regex pattern(R"(\\tag\{([A-Za-z0-9]+)\})");
  std::vector<std::string> found;
  for (const std::string& line : lines_of(kRoot / page.folder / "THEORY.md")) {
    for (const std::string& number : all_matches(line, pattern)) found.push_back(number);
  }
  return found;
}

bool is_source(const fs::path& path) { return path.extension() == ".h" || path.extension() == ".cpp"; }

/// Sources of a folder and what is below it, and its pages too if wanted.
std::vector<fs::path> files_of(const std::string& folder, bool with_pages) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
    const bool is_page = with_pages && entry.path().extension() == ".md";
    if (entry.is_regular_file() && (is_source(entry.path()) || is_page)) files.push_back(entry.path());
  }
  return files;
}

std::set<std::string> all_definitions() {
  std::set<std::string> numbers;
  for (const Page& page : kPages) {
    for (const std::string& number : definitions(page)) numbers.insert(number);
  }
  return numbers;
}

TEST(Theory, EachPageNumbersItsEquationsWithoutGaps) {
  for (const Page& page : kPages) {
    const std::vector<std::string> numbers = definitions(page);
    EXPECT_GE(numbers.size(), 20U) << page.folder;
    for (std::size_t k = 0; k < numbers.size(); ++k) EXPECT_EQ(numbers[k], page.letter + std::to_string(k + 1));
  }
}

TEST(Theory, EveryNumberThatIsCitedExists) {
  const std::set<std::string> numbers = all_definitions();
  for (const std::string folder : {"common", "cartesian", "relative", "compare", "tests"}) {
    for (const fs::path& path : files_of(folder, true)) {
      if (path.filename() == "theory_test.cpp") continue;
      for (const std::string& line : lines_of(path)) {
        for (const std::string& number : citations(line)) {
          EXPECT_EQ(numbers.count(number), 1U) << path << " cites (" << number << "), which no page has: " << line;
        }
      }
    }
  }
}

TEST(Theory, EveryEquationIsCitedByASourceOfItsFolder) {
  for (const Page& page : kPages) {
    std::set<std::string> cited;
    for (const fs::path& path : files_of(page.folder, false)) {
      for (const std::string& line : lines_of(path)) {
        for (const std::string& number : citations(line)) cited.insert(number);
      }
    }
    for (const std::string& number : definitions(page)) {
      EXPECT_EQ(cited.count(number), 1U) << "no source in " << page.folder << " cites (" << number << ")";
    }
  }
}

TEST(Theory, EachDerivationStandsByItself) {
  for (const Page& page : kPages) {
    for (const fs::path& path : files_of(page.folder, true)) {
      for (const std::string& line : lines_of(path)) {
        for (const std::string& number : citations(line)) {
          const bool is_own = number.front() == page.letter || number.front() == 'S';
          EXPECT_TRUE(is_own) << path << " leans on (" << number << "): " << line;
        }
      }
    }
  }
}

TEST(Theory, NoSourceCitesAPageOutsideTheProject) {
  const std::string citation = std::string("formulation") + " section";  // in two parts: this file is read too
  for (const std::string folder : {"common", "cartesian", "relative", "compare", "tests"}) {
    for (const fs::path& path : files_of(folder, false)) {
      for (const std::string& line : lines_of(path)) {
        EXPECT_EQ(line.find(citation), std::string::npos) << path << ": " << line;
      }
    }
  }
}

TEST(Theory, LinesOfThePagesFit) {
  for (const Page& page : kPages) {
    for (const std::string& line : lines_of(kRoot / page.folder / "THEORY.md")) EXPECT_LE(line.size(), 120U) << line;
  }
}

/// A row of a README's table: | equations | paper | what | functions | file |.
struct TableRow {
  std::string text;
  std::vector<std::string> equations;
  std::vector<std::string> of_paper;
  std::vector<std::string> functions;
  std::string file;
};

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::size_t from = 1;
  for (std::size_t bar = line.find('|', from); bar != std::string::npos; bar = line.find('|', from)) {
    cells.push_back(line.substr(from, bar - from));
    from = bar + 1;
  }
  return cells;
}

/// "(25)" and "(26)" of "paper (25), (26)".
std::vector<std::string> paper_numbers(const std::string& text) {
  static const std::regex pattern(R"((\([0-9]+\)))");
  return all_matches(text, pattern);
}

std::vector<TableRow> table_of(const Page& page) {
  static const std::regex quoted("`([^`]+)`");
  std::vector<TableRow> rows;
  bool is_inside = false;
  for (const std::string& line : lines_of(kRoot / page.folder / "README.md")) {
    if (line.rfind("## ", 0) == 0) is_inside = line == "## Equation by equation";
    if (!is_inside || line.rfind("| (", 0) != 0) continue;
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() != 5) {
      ADD_FAILURE() << page.folder << "/README.md: five columns expected: " << line;
      continue;
    }
    const std::vector<std::string> files = all_matches(cells[4], quoted);
    EXPECT_EQ(files.size(), 1U) << line;
    rows.push_back({line, citations(cells[0]), paper_numbers(cells[1]), all_matches(cells[3], quoted),
                    files.empty() ? "" : files.front()});
  }
  return rows;
}

/// The sources that a file in the table stands for.
std::vector<std::vector<std::string>> sources_of(const Page& page, const std::string& file) {
  std::vector<std::vector<std::string>> sources;
  for (const std::string end : {".h", "_inline.h", ".cpp"}) {
    const fs::path path = kRoot / page.folder / (file + end);
    if (fs::exists(path)) sources.push_back(lines_of(path));
  }
  return sources;
}

bool is_part_of_a_name(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// Whether a line holds the text, and not as a part of a longer name.
bool holds(const std::string& line, const std::string& text) {
  for (std::size_t at = line.find(text); at != std::string::npos; at = line.find(text, at + 1)) {
    const std::size_t after = at + text.size();
    const bool begins = at == 0 || !is_part_of_a_name(line[at - 1]) || !is_part_of_a_name(text.front());
    const bool ends = after == line.size() || !is_part_of_a_name(line[after]) || !is_part_of_a_name(text.back());
    if (begins && ends) return true;
  }
  return false;
}

std::vector<int> places_of(const std::vector<std::string>& lines, const std::string& text) {
  std::vector<int> places;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (holds(lines[k], text)) places.push_back(static_cast<int>(k));
  }
  return places;
}

bool stand_together(const std::vector<std::vector<std::string>>& sources, const std::string& function,
                    const std::string& equation) {
  for (const std::vector<std::string>& lines : sources) {
    const std::vector<int> citations = places_of(lines, "(" + equation + ")");
    for (const int name : places_of(lines, function)) {
      const auto is_near = [name](int citation) { return std::abs(name - citation) <= kNear; };
      if (std::any_of(citations.begin(), citations.end(), is_near)) return true;
    }
  }
  return false;
}

TEST(TheoryTables, EveryEquationLeadsToAFunctionThatCitesIt) {
  for (const Page& page : kPages) {
    std::set<std::string> found;
    for (const TableRow& row : table_of(page)) {
      const auto sources = sources_of(page, row.file);
      EXPECT_FALSE(sources.empty()) << "no such file: " << row.text;
      EXPECT_FALSE(row.functions.empty()) << row.text;
      for (const std::string& equation : row.equations) {
        found.insert(equation);
        const bool is_cited = std::any_of(row.functions.begin(), row.functions.end(), [&](const std::string& function) {
          return stand_together(sources, function, equation);
        });
        EXPECT_TRUE(is_cited) << "none of its functions cites (" << equation << "): " << row.text;
      }
    }
    for (const std::string& number : definitions(page)) {
      EXPECT_EQ(found.count(number), 1U) << page.folder << "/README.md has no function for (" << number << ")";
    }
  }
}

TEST(TheoryTables, EveryFunctionCitesAnEquationOfItsRow) {
  for (const Page& page : kPages) {
    for (const TableRow& row : table_of(page)) {
      const auto sources = sources_of(page, row.file);
      for (const std::string& function : row.functions) {
        const bool cites = std::any_of(row.equations.begin(), row.equations.end(), [&](const std::string& equation) {
          return stand_together(sources, function, equation);
        });
        EXPECT_TRUE(cites) << "`" << function << "` cites none of its equations: " << row.text;
      }
    }
  }
}

/// A reader who comes with the paper finds where each of its equations is computed.
TEST(TheoryTables, EveryEquationOfThePaperThatAPageNamesLeadsToAFunction) {
  static const std::regex named(R"([Pp]aper ((\([0-9]+\)(, | and )?)+))");
  for (const Page& page : kPages) {
    std::set<std::string> found;
    for (const TableRow& row : table_of(page)) found.insert(row.of_paper.begin(), row.of_paper.end());
    std::string text;
    for (const std::string& line : lines_of(kRoot / page.folder / "THEORY.md")) text += line + " ";
    const std::vector<std::string> lists = all_matches(text, named);
    EXPECT_FALSE(lists.empty()) << page.folder;
    for (const std::string& list : lists) {
      for (const std::string& number : paper_numbers(list)) {
        EXPECT_EQ(found.count(number), 1U) << page.folder << "/README.md has no function for the paper's " << number;
      }
    }
  }
}

}  // namespace
}  // namespace concord::manual
