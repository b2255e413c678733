#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

/// The figures that READMEs print, held against what the program says.
namespace {

namespace fs = std::filesystem;

const fs::path kSource = CONCORD_SOURCE;

/// What a README promises of digits that it prints: the last tenths depend on the compiler.
constexpr double kTenths = 0.5;

std::string read(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::string output_of(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::string text;
  for (int byte = std::fgetc(pipe); byte != EOF; byte = std::fgetc(pipe)) text += static_cast<char>(byte);
  CHECK(pclose(pipe) == 0);
  return text;
}

/// The cells of a table's rows, without the line of dashes.
std::vector<std::vector<std::string>> rows_of(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| ")) continue;
    std::vector<std::string> cells;
    std::istringstream in(line.substr(1));
    for (std::string cell; std::getline(in, cell, '|');) {
      const std::size_t first = cell.find_first_not_of(' ');
      cells.push_back(first == std::string::npos ? "" : cell.substr(first, cell.find_last_not_of(' ') - first + 1));
    }
    rows.push_back(std::move(cells));
  }
  return rows;
}

/// All numbers in a text, in order.
std::vector<double> numbers_in(const std::string& text) {
  static const std::regex number(R"([0-9]+(\.[0-9]+)?)");
  std::vector<double> numbers;
  for (std::sregex_iterator it(text.begin(), text.end(), number); it != std::sregex_iterator(); ++it) {
    numbers.push_back(std::stod(it->str()));
  }
  return numbers;
}

void require_same_within(const std::string& printed, const std::string& told, double allowed) {
  INFO("printed: " << printed << "\ntold:    " << told);
  const std::vector<double> one = numbers_in(printed);
  const std::vector<double> other = numbers_in(told);
  REQUIRE(one.size() == other.size());
  for (std::size_t k = 0; k < one.size(); ++k) CHECK(std::abs(one[k] - other[k]) <= allowed * (1.0 + 1e-9));
}

std::string line_beginning(const std::string& text, const std::string& words) {
  const std::size_t begin = text.find("\n" + words);
  REQUIRE(begin != std::string::npos);
  return text.substr(begin + 1, text.find('\n', begin + 1) - begin - 1);
}

/// Of a suite's accepted results: the fewest digits of a case's components, by column.
std::vector<double> accepted_digits(const std::string& name) {
  std::istringstream lines(read(kSource / "data/baselines/nightly.csv"));
  std::vector<double> least(4, INFINITY);
  bool is_asked_for = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("case,")) is_asked_for = line.starts_with("case," + name + ",");
    if (!is_asked_for || !line.starts_with(',')) continue;
    const std::size_t behind_name = line[1] == '"' ? line.find('"', 2) + 2 : line.find(',', 1) + 1;
    std::istringstream cells(line.substr(behind_name));
    std::string cell;
    for (double& digits : least) {
      if (std::getline(cells, cell, ',') && cell != "-") digits = std::min(digits, std::stod(cell));
    }
  }
  return least;
}

}  // namespace

TEST_CASE("The first table of the README is what the program prints", "[program]") {
  const std::string page = read(kSource / "README.md");
  const std::string told = output_of("'" CONCORD_PROGRAM "' compare '" +
                                     (kSource / "data/models/slider_crank_flexible.toml").string() + "'");
  const std::size_t begin = page.find("\n| joint | on ");
  const auto printed = rows_of(page.substr(begin, page.find("```", begin) - begin));
  // The page ends with "..." where the program goes on with the pose at the start.
  const auto rows = rows_of(told.substr(0, told.find("\n| joint | coordinate ")));
  REQUIRE(printed.size() == 11);
  REQUIRE(rows.size() == printed.size());
  for (std::size_t k = 0; k < printed.size(); ++k) {
    REQUIRE(rows[k].size() == printed[k].size());
    const std::size_t digits = printed[k].size() - 2;
    for (std::size_t column = 0; column < printed[k].size(); ++column) {
      if (column != digits) CHECK(rows[k][column] == printed[k][column]);
    }
    // Which component and check are nearest to their need may depend on the compiler.
    const auto numbers = [&](const auto& row) { return numbers_in(row[digits]); };
    if (k == 0 || k == 9 || numbers(printed[k]).back() != numbers(rows[k]).back()) continue;
    require_same_within(printed[k][digits], rows[k][digits], kTenths);
  }
  const std::string last = line_beginning(page, "agree slider_crank_flexible");
  const std::string last_told = line_beginning(told, "agree slider_crank_flexible");
  require_same_within(last, last_told, kTenths);
  const std::regex digits(" [0-9]+\\.[0-9]");
  CHECK(std::regex_replace(last, digits, "") == std::regex_replace(last_told, digits, ""));
}

TEST_CASE("The digits of the cars that the READMEs print are those that were accepted", "[quick]") {
  const std::string models = read(kSource / "data/models/README.md");
  const std::map<std::string, std::string> sentences{{"car", "`car` "},
                                                     {"car_left_bump", "`car_left_bump` "},
                                                     {"car_steering_step", "`car_steering_step` "},
                                                     {"car_flexible_beam", "`car_flexible_beam` "}};
  for (const auto& [name, words] : sentences) {
    INFO(name);
    const std::regex figures(words + R"((\d+\.\d) / (\d+\.\d) / (\d+\.\d) / \d+\.\d)");
    std::smatch printed;
    REQUIRE(std::regex_search(models, printed, figures));
    const std::vector<double> accepted = accepted_digits(name);  // same state, resolvable, same run, refined
    CHECK(std::abs(std::stod(printed[1]) - accepted[0]) <= kTenths);
    CHECK(std::abs(std::stod(printed[2]) - accepted[2]) <= kTenths);
    CHECK(std::abs(std::stod(printed[3]) - accepted[3]) <= kTenths);
  }
  std::smatch printed;
  const std::string page = std::regex_replace(read(kSource / "README.md"), std::regex("\\s+"), " ");
  const std::regex figures(
      R"(All 206 components agree: (\d+\.\d) digits in the same state, (\d+\.\d) in the same run)");
  REQUIRE(std::regex_search(page, printed, figures));
  CHECK(std::abs(std::stod(printed[1]) - accepted_digits("car")[0]) <= kTenths);
  CHECK(std::abs(std::stod(printed[2]) - accepted_digits("car")[2]) <= kTenths);
}
