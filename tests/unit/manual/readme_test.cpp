#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/unit/manual/pages.h"

/// The READMEs against the program and the folders: command lines that they print have options that exist, paths that
/// they name exist, and their lines fit.
namespace concord::manual {
namespace {

struct PageLine {
  fs::path page;
  int number = 0;
  std::string text;
  bool is_code = false;
};

std::string place(const PageLine& line) {
  return fs::relative(line.page, kRoot).generic_string() + ":" + std::to_string(line.number) + ": " + line.text;
}

bool is_manual_page(const fs::path& path) { return path.extension() == ".md" && path.filename() != "THEORY.md"; }

std::vector<fs::path> manual_pages() {
  std::vector<fs::path> pages{kRoot / "README.md", kRoot / ".github/CONTRIBUTING.md"};
  for (const std::string folder : {"common", "cartesian", "relative", "compare", "data", "tests"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      if (is_manual_page(entry.path())) pages.push_back(entry.path());
    }
  }
  return pages;
}

std::vector<PageLine> manual_lines() {
  std::vector<PageLine> lines;
  for (const fs::path& page : manual_pages()) {
    PageLine line{page, 0, "", false};
    for (std::string& text : lines_of(page)) {
      line.text = std::move(text);
      ++line.number;
      const bool is_fence = line.text.rfind("```", 0) == 0;
      if (is_fence) line.is_code = !line.is_code;
      if (!is_fence) lines.push_back(line);
    }
  }
  return lines;
}

/// Text in backquotes, and the whole line in a code block.
std::vector<std::string> code_in(const PageLine& line) {
  static const std::regex quoted("`([^`]+)`");
  if (line.is_code) return {line.text};
  return all_matches(line.text, quoted);
}

TEST(Readme, LinesOfProseFit) {
  for (const PageLine& line : manual_lines()) {
    const bool may_be_longer = line.is_code || line.text.rfind('|', 0) == 0 || line.text.rfind("![", 0) == 0;
    EXPECT_TRUE(may_be_longer || line.text.size() <= 120) << place(line) << ": " << line.text.size() << " columns";
  }
}

bool is_heading(const std::string& text) { return std::regex_search(text, std::regex("^#+ ")); }

/// A line that begins no paragraph and goes on with none: of a list, a table, a picture, a heading, code.
bool stands_alone(const std::string& text) {
  static const std::regex alone(R"(^$|^ *([*+-]|[0-9]+\.) |^[|<!>\[]|^#+ |^```|^ {4})");
  return std::regex_search(text, alone);
}

/// A heading behind a line of text belongs to that line's paragraph; one that is as long as a line has swallowed its
/// own.
TEST(Readme, HeadingsStandAlone) {
  constexpr std::size_t kLongest = 90;
  std::string before;
  fs::path page;
  for (const PageLine& line : manual_lines()) {
    const bool is_first = line.page != page;
    page = line.page;
    if (!line.is_code && is_heading(line.text)) {
      EXPECT_TRUE(is_first || before.empty() || is_heading(before))
          << "no blank line before the heading: " << place(line);
      EXPECT_LE(line.text.size(), kLongest) << "the heading has swallowed its paragraph: " << place(line);
    }
    before = line.text;
  }
}

/// Finds a line that was broken off: the first word of the next one would have had room, or it begins as if it were the
/// row of a table.
TEST(Readme, ParagraphsFillTheirLines) {
  constexpr std::size_t kRoom = 95;
  const std::vector<PageLine> lines = manual_lines();
  for (std::size_t k = 0; k + 1 < lines.size(); ++k) {
    const PageLine& line = lines[k];
    if (line.is_code) continue;
    const bool is_row = line.text.rfind('|', 0) == 0;
    EXPECT_TRUE(!is_row || line.text.back() == '|') << "a row of a table ends with '|': " << place(line);
    const PageLine& next = lines[k + 1];
    const bool goes_on = next.page == line.page && next.number == line.number + 1 && !next.is_code;
    const bool ends_here = line.text.empty() || is_row || is_heading(line.text) || line.text.rfind("    ", 0) == 0;
    if (!goes_on || ends_here || stands_alone(next.text)) continue;
    const std::size_t word = std::min(next.text.find(' ', next.text.find_first_not_of(' ')), next.text.size());
    EXPECT_GT(line.text.size() + 1 + word, kRoom) << "the line is broken off: " << place(line);
  }
}

TEST(Readme, EveryLinkLeadsToAFile) {
  static const std::regex link(R"(\]\(([^)# ]+)[^)]*\))");
  int links = 0;
  for (const PageLine& line : manual_lines()) {
    if (line.is_code) continue;
    for (const std::string& target : all_matches(line.text, link)) {
      if (target.find("://") != std::string::npos) continue;
      ++links;
      EXPECT_TRUE(fs::exists(line.page.parent_path() / target)) << "no such file: " << target << "\n" << place(line);
    }
  }
  EXPECT_GE(links, 50);
}

/// Paths from the root of the project begin with one of its folders; patterns and names in angle brackets are left out,
/// and so is what a build makes.
TEST(Readme, EveryPathThatIsNamedExists) {
  static const std::regex path(
      R"((?:^|[ =(])((?:common|cartesian|relative|compare|data|tests|\.github|\.ci)/[A-Za-z0-9_./]+))");
  const std::vector<std::string> endings{"", ".h", ".cpp"};
  int paths = 0;
  for (const PageLine& line : manual_lines()) {
    for (const std::string& code : code_in(line)) {
      if (code.find_first_of("*<>{") != std::string::npos) continue;
      for (const std::string& name : all_matches(code, path)) {
        ++paths;
        bool is_there = false;
        for (const std::string& ending : endings) is_there = is_there || fs::exists(kRoot / (name + ending));
        EXPECT_TRUE(is_there) << "no such file: " << name << "\n" << place(line);
      }
    }
  }
  EXPECT_GE(paths, 30);
}

#ifdef CONCORD_PROGRAM
std::string output_of(const std::string& command) {
  std::string output;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return output;
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) output += buffer.data();
  pclose(pipe);
  return output;
}

std::set<std::string> options_in(const std::string& text) {
  static const std::regex option("(--[a-z][a-z-]*)");
  const std::vector<std::string> found = all_matches(text, option);
  return {found.begin(), found.end()};
}

/// The options of a subcommand as its --help lists them; none if there is no such subcommand.
std::set<std::string> options_of(const std::string& subcommand) {
  static const std::string program = std::string("'") + CONCORD_PROGRAM + "' ";
  static const std::string overview = output_of(program + "--help");
  if (overview.find("\n  " + subcommand + " ") == std::string::npos) return {};
  return options_in(output_of(program + subcommand + " --help"));
}

/// The commands that the program's --help lists.
std::vector<std::string> commands_of_program() {
  static const std::regex command("\n  ([a-z]+) {3}");
  const std::string overview = output_of(std::string("'") + CONCORD_PROGRAM + "' --help");
  const auto first = overview.find("Subcommands:");
  return all_matches(overview.substr(first, overview.find("Examples") - first), command);
}

/// The arguments of the examples that the help of a command ends with.
std::vector<std::string> examples_in(const std::string& help, const std::string& command) {
  const std::regex example("\n  concord " + command + " +([^\n]+)");
  const auto first = help.find("\nExamples:\n");
  return first == std::string::npos ? std::vector<std::string>() : all_matches(help.substr(first), example);
}

TEST(Readme, HelpOfEveryCommandEndsWithItsOwnExamples) {
  static const std::regex path("(?:^| )((?:data|compare)/[A-Za-z0-9_./]+)");
  const std::vector<std::string> commands = commands_of_program();
  EXPECT_GE(commands.size(), 15U);
  for (const std::string& command : commands) {
    const std::string help = output_of(std::string("'") + CONCORD_PROGRAM + "' " + command + " --help");
    const std::string before = help.substr(0, help.find("\nExamples:\n"));
    const std::vector<std::string> examples = examples_in(help, command);
    EXPECT_GE(examples.size(), 2U) << command << '\n' << help;
    static const std::regex any("\n  concord ([a-z]+)");
    EXPECT_EQ(all_matches(help, any).size(), examples.size()) << command << " shows examples of other commands";
    for (const std::string& arguments : examples) {
      for (const std::string& option : options_in(arguments.substr(0, arguments.find("--slurm ")))) {
        EXPECT_EQ(options_in(before).count(option), 1U) << command << " has no " << option;
      }
      for (const std::string& file : all_matches(arguments, path)) {
        EXPECT_TRUE(fs::exists(kRoot / file)) << command << ": no such file: " << file;
      }
    }
  }
}

/// A command line in a code block ends at a comment or at the next command; in prose it is what the backquotes hold.
TEST(Readme, EveryCommandLineHasOptionsThatExist) {
  static const std::regex command(R"re((?:^|[ /])(?:compare/run|concord) +([a-z]+(?: +[^ #&|]+)*))re");
  std::map<std::string, std::set<std::string>> known;
  int commands = 0;
  for (const PageLine& line : manual_lines()) {
    for (const std::string& code : code_in(line)) {
      for (const std::string& arguments : all_matches(code, command)) {
        const std::string subcommand = arguments.substr(0, arguments.find(' '));
        if (known.count(subcommand) == 0) known[subcommand] = options_of(subcommand);
        const std::set<std::string>& options = known[subcommand];
        const bool is_command_line = arguments.find("--") != std::string::npos || line.is_code;
        if (options.empty() && !is_command_line) continue;  // "concord night" names a format
        ++commands;
        EXPECT_FALSE(options.empty()) << "no such subcommand: " << subcommand << "\n" << place(line);
        for (const std::string& option : options_in(arguments)) {
          EXPECT_EQ(options.count(option), 1U) << subcommand << " has no " << option << "\n" << place(line);
        }
      }
    }
  }
  EXPECT_GE(commands, 30);
}
#endif

}  // namespace
}  // namespace concord::manual
