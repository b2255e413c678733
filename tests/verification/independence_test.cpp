#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

/// What the two solvers share they cannot verify: so neither knows the other, the comparator knows neither, and the
/// common library holds no mechanics that both could get wrong together.
namespace {

namespace fs = std::filesystem;

const fs::path kSource = CONCORD_SOURCE;
const fs::path kBuild = fs::path(CONCORD_PROGRAM).parent_path().parent_path();

std::string read(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

/// Output of a shell command that must succeed.
std::string output_of(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::string text;
  std::array<char, 4096> buffer{};
  while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), pipe)) text.append(buffer.data(), count);
  INFO(command);
  REQUIRE(pclose(pipe) == 0);
  return text;
}

std::vector<fs::path> sources_of(const std::string& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(kSource / folder)) {
    if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp") files.push_back(entry.path());
  }
  REQUIRE_FALSE(files.empty());
  return files;
}

/// First folders of all that the file includes from the project.
std::vector<std::string> included_folders(const fs::path& file) {
  static const std::regex include(R"(#\s*include\s*["<](?:\.\./)*(common|cartesian|relative|compare)/)");
  const std::string text = read(file);
  std::vector<std::string> folders;
  for (std::sregex_iterator hit(text.begin(), text.end(), include), end; hit != end; ++hit)
    folders.push_back((*hit)[1]);
  return folders;
}

void require_no_include(const std::string& folder, const std::vector<std::string>& forbidden) {
  for (const fs::path& file : sources_of(folder)) {
    // The program joins both solvers, and so do the Python module and the joint check.
    const std::string here = file.parent_path().filename().string();
    if (here == "program" || here == "python" || here == "joint_check") continue;
    for (const std::string& found : included_folders(file)) {
      for (const std::string& other : forbidden) {
        INFO(file << " includes from " << found);
        CHECK(found != other);
      }
    }
  }
}

/// Of a folder such as "common" or "compare/audit".
fs::path library(const fs::path& folder) {
  return kBuild / folder / ("libconcord_" + folder.filename().string() + ".a");
}

/// Demangled names of a folder's library, defined there or used from elsewhere.
std::string symbols_of(const std::string& folder, const std::string& which) {
  return output_of("nm -C " + which + " '" + library(folder).string() + "' 2>/dev/null");
}

bool mentions(const std::string& symbols, const std::string& name_space) {
  return symbols.find("concord::" + name_space + "::") != std::string::npos;
}

/// Names of the libraries and objects that a target of the build is linked from.
std::string link_line(const std::string& executable) {
  return output_of("ninja -C '" + kBuild.string() + "' -t commands " + executable + " | tail -n 1");
}

}  // namespace

TEST_CASE("Neither solver includes the other, the comparator neither, common none of them", "[independence]") {
  require_no_include("cartesian", {"relative", "compare"});
  require_no_include("relative", {"cartesian", "compare"});
  require_no_include("compare", {"cartesian", "relative"});
  require_no_include("common", {"cartesian", "relative", "compare"});
  require_no_include("tests/unit/cartesian", {"relative", "compare"});
  require_no_include("tests/unit/relative", {"cartesian", "compare"});
  for (const char* folder : {"audit", "quantities", "states", "resolution", "verdict", "report"}) {
    require_no_include(std::string("tests/unit/") + folder, {"cartesian", "relative"});
  }
}

TEST_CASE("Neither solver links the other, the comparator neither", "[independence]") {
  const auto links = [](const std::string& executable, const std::string& folder) {
    return link_line(executable).find("libconcord_" + folder + ".a") != std::string::npos;
  };
  CHECK(links("tests/unit_cartesian", "cartesian"));
  CHECK_FALSE(links("tests/unit_cartesian", "relative"));
  CHECK_FALSE(links("tests/unit_cartesian", "audit"));
  CHECK(links("tests/unit_relative", "relative"));
  CHECK_FALSE(links("tests/unit_relative", "cartesian"));
  CHECK_FALSE(links("tests/unit_relative", "audit"));
  CHECK(links("tests/unit_report", "verdict"));
  CHECK_FALSE(links("tests/unit_report", "cartesian"));
  CHECK_FALSE(links("tests/unit_report", "relative"));
}

TEST_CASE("No library defines or uses symbols of a folder that it must not know", "[independence]") {
  for (const auto& [folder, others] :
       {std::pair<std::string, std::vector<std::string>>{"cartesian", {"relative", "compare"}},
        {"relative", {"cartesian", "compare"}},
        {"compare/audit", {"cartesian", "relative"}},
        {"compare/quantities", {"cartesian", "relative"}},
        {"compare/states", {"cartesian", "relative"}},
        {"compare/resolution", {"cartesian", "relative"}},
        {"compare/verdict", {"cartesian", "relative"}},
        {"compare/report", {"cartesian", "relative"}},
        {"compare/analyses", {"cartesian", "relative"}},
        {"common", {"cartesian", "relative", "compare"}}}) {
    const std::string symbols = symbols_of(folder, "");
    REQUIRE(symbols.find("concord::") != std::string::npos);
    for (const std::string& other : others) {
      INFO(folder << " against " << other);
      CHECK_FALSE(mentions(symbols, other));
    }
  }
  CHECK(mentions(symbols_of("cartesian", "--defined-only"), "cartesian"));
  CHECK(mentions(symbols_of("relative", "--defined-only"), "relative"));
}

namespace {

/// What a line of `nm -C` defines: "concord::skew" of "0000 T concord::skew(...)", and whether a compiler may leave it
/// out. Nothing for names outside the project, special members and instances of templates.
std::optional<std::pair<std::string, bool>> exported_in(const std::string& line) {
  static const std::regex pattern(R"(^[0-9a-f]+ ([TDBRW]) (concord::[A-Za-z0-9_:*+\-/]+)(\[abi:cxx11\])?(\(.*)?$)");
  static const std::regex special(R"((^|::)(operator=|~.*|([A-Za-z0-9_]+)::\3)$)");
  std::smatch found;
  if (!std::regex_match(line, found, pattern) || std::regex_search(found[2].first, found[2].second, special)) return {};
  return std::pair{found[2].str(), found[1] == "W"};
}

}  // namespace

TEST_CASE("Common exports what its list says: no mass matrix, constraint Jacobian or body kinematics",
          "[independence]") {
  std::set<std::string> listed;
  std::set<std::string> may_be_missing;
  std::istringstream list(read(kSource / "tests" / "layout" / "exports_of_common.txt"));
  for (std::string line; std::getline(list, line);) {
    if (line.empty() || line.front() == '#') continue;
    const bool is_inline = line.rfind("inline ", 0) == 0;
    (is_inline ? may_be_missing : listed).insert(is_inline ? line.substr(7) : line);
  }
  REQUIRE(listed.size() > 100);
  std::set<std::string> exported;
  std::istringstream lines(symbols_of("common", "--defined-only --extern-only"));
  for (std::string line; std::getline(lines, line);) {
    const auto symbol = exported_in(line);
    if (!symbol) continue;
    const auto& [name, may_be_left_out] = *symbol;
    INFO("common exports " << name << ": add it to tests/layout/exports_of_common.txt only if it is no mechanics");
    CHECK((listed.count(name) + may_be_missing.count(name)) == 1);
    if (!may_be_left_out) exported.insert(name);
  }
  for (const std::string& name : listed) {
    INFO("tests/layout/exports_of_common.txt lists " << name << ", which common does not export");
    CHECK(exported.count(name) == 1);
  }
}

TEST_CASE("Each solver builds and passes its tests with the other one absent", "[independence][nightly]") {
  for (const auto& [kept, absent] : {std::pair{"relative", "cartesian"}, {"cartesian", "relative"}}) {
    const fs::path copy = fs::temp_directory_path() / (std::string("concord_without_") + absent);
    fs::remove_all(copy);
    fs::create_directories(copy);
    for (const char* folder : {"common", "compare", "tests", "data", kept}) {
      fs::copy(kSource / folder, copy / folder, fs::copy_options::recursive);
    }
    fs::copy(kSource / "CMakeLists.txt", copy / "CMakeLists.txt");
    const std::string target = std::string("unit_") + kept;
    const std::string build = "'" + (copy / "build").string() + "'";
    output_of(fmt::format("cmake -G Ninja -S '{}' -B {} > /dev/null", copy.string(), build));
    output_of(fmt::format("ninja -C {} {} > /dev/null", build, target));
    const std::string told = output_of(fmt::format("{}/tests/{} | tail -n 5", build, target));
    CHECK(told.find("PASSED") != std::string::npos);
    fs::remove_all(copy);
  }
}
