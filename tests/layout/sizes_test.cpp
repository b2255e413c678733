#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/layout/source_sizes.h"

namespace concord::layout {
namespace {

namespace fs = std::filesystem;

constexpr int kMostLinesOfFile = 400;
constexpr int kMostLinesOfFunction = 50;

/// What is longer than its limit: "file" or "file:function", and its lines.
std::map<std::string, int> too_long() {
  std::map<std::string, int> found;
  for (const auto& [path, text] : sources(CONCORD_SOURCE)) {
    if (count_lines(text) > kMostLinesOfFile) found[path] = count_lines(text);
    for (const FunctionSize& one : function_sizes(text)) {
      if (one.lines > kMostLinesOfFunction) found[path + ":" + one.name] = one.lines;
    }
  }
  return found;
}

struct Exception {
  int lines = 0;
  std::string reason;
};

/// layout/sizes.txt, by file or file:function.
std::map<std::string, Exception> exceptions() {
  std::map<std::string, Exception> listed;
  std::istringstream text(text_of(fs::path(CONCORD_SOURCE) / "tests/layout/sizes.txt"));
  const std::regex entry(R"(([\w/.]+(?::[\w:~]+)?): (\d+): (\S.*))");
  std::string line;
  while (std::getline(text, line)) {
    if (line.empty() || line.front() == '#') continue;
    std::smatch match;
    if (!std::regex_match(line, match, entry)) {
      ADD_FAILURE() << "sizes.txt: expected 'file: lines: reason' or 'file:function: lines: reason': " << line;
      continue;
    }
    listed[match[1]] = {std::stoi(match[2]), match[3]};
  }
  return listed;
}

TEST(Sizes, FilesHaveAtMost400LinesAndFunctions50OrStandInTheListWithTheirSize) {
  const std::map<std::string, Exception> listed = exceptions();
  for (const auto& [what, lines] : too_long()) {
    const auto known = listed.find(what);
    if (known == listed.end()) {
      ADD_FAILURE() << what << ": " << lines << " lines: split it by concept";
    } else {
      EXPECT_LE(lines, known->second.lines) << what << " has grown beyond what tests/layout/sizes.txt grants it";
    }
  }
}

TEST(Sizes, TheListNamesNothingThatFits) {
  const std::map<std::string, int> found = too_long();
  for (const auto& [what, exception] : exceptions()) {
    EXPECT_TRUE(found.contains(what)) << what << " is within the limits: strike it from tests/layout/sizes.txt";
  }
}

TEST(Sizes, TheScannerFindsTheFunctionsOfTheProject) {
  int count = 0;
  for (const auto& [path, text] : sources(CONCORD_SOURCE)) count += static_cast<int>(function_sizes(text).size());
  EXPECT_GT(count, 3000) << "fewer functions than the project has: the scanner misses some";
}

std::vector<std::string> names_and_lines(std::string_view source) {
  std::vector<std::string> found;
  for (const FunctionSize& one : function_sizes(source)) found.push_back(one.name + " " + std::to_string(one.lines));
  return found;
}

TEST(FunctionSizes, CountFromTheFirstLineOfTheDeclarationToTheClosingBrace) {
  EXPECT_THAT(names_and_lines("namespace a {\n"
                              "/// Not counted.\n"
                              "template <class T>\n"
                              "int f(int x,\n"
                              "      int y) {\n"
                              "  if (x) {\n"
                              "    return y;\n"
                              "  }\n"
                              "}\n"
                              "}\n"),
              testing::ElementsAre("f 7"));
}

TEST(FunctionSizes, SeeMembersOperatorsAndConstructorsWithBracesBeforeTheirBodies) {
  EXPECT_THAT(names_and_lines("class A {\n"
                              " public:\n"
                              "  A(int x) : a_(x), b_{x} {\n"
                              "  }\n"
                              "  ~A() { }\n"
                              "  A& operator=(const A& other) {\n"
                              "    return *this;\n"
                              "  }\n"
                              "  bool operator()(int x) const { return x > 0; }\n"
                              "  [[nodiscard]] int get() const noexcept { return a_; }\n"
                              " private:\n"
                              "  int a_ = 0;\n"
                              "  std::array<int, 2> b_{1, 2};\n"
                              "};\n"
                              "A::A(int x)\n"
                              "    : a_{x} {\n"
                              "}\n"),
              testing::ElementsAre("A 2", "~A 1", "operator= 3", "operator() 1", "get 1", "A::A 3"));
}

TEST(FunctionSizes, TakeLambdasAndLocalClassesForPartsOfTheirFunction) {
  EXPECT_THAT(names_and_lines("void f() {\n"
                              "  const auto g = [](int x) {\n"
                              "    return x;\n"
                              "  };\n"
                              "  struct B {\n"
                              "    void h() {}\n"
                              "  };\n"
                              "}\n"),
              testing::ElementsAre("f 8"));
}

TEST(FunctionSizes, AreNotLedAstrayByTextsCommentsAndValues) {
  EXPECT_THAT(names_and_lines("#define OPEN {\n"
                              "const char* text = \"void g() {\";\n"
                              "const char* raw = R\"x(void h() { \" )x\";\n"
                              "constexpr int million = 1'000'000;  // int k() {\n"
                              "/* void m() { */\n"
                              "const std::vector<int> values{f(1), f(2)};\n"
                              "const Point point = make(Point{1, 2});\n"
                              "enum class E { one, two };\n"
                              "struct S : T<int> { int x{0}; };\n"
                              "void declared(Options options = {});\n"
                              "char c = '{';\n"
                              "void f() {\n"
                              "}\n"),
              testing::ElementsAre("f 2"));
}

TEST(FunctionSizes, SeeWhatFollowsATrailingReturnType) {
  EXPECT_THAT(names_and_lines("auto f(int x) -> std::vector<int> {\n  return {x};\n}\nint g() { return 1; }\n"),
              testing::ElementsAre("f 3", "g 1"));
}

TEST(CountLines, CountsALastLineWithoutItsEnd) {
  EXPECT_EQ(count_lines(""), 0);
  EXPECT_EQ(count_lines("a\nb\n"), 2);
  EXPECT_EQ(count_lines("a\nb"), 2);
}

}  // namespace
}  // namespace concord::layout
