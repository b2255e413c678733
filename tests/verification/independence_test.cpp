#include <array>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
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
    if (file == kSource / "compare" / "main.cpp") continue;  // the program joins them, and so does the joint check
    if (file.parent_path() == kSource / "compare" / "joint_check") continue;
    for (const std::string& found : included_folders(file)) {
      for (const std::string& other : forbidden) {
        INFO(file << " includes from " << found);
        CHECK(found != other);
      }
    }
  }
}

fs::path library(const std::string& folder) { return kBuild / folder / ("libconcord_" + folder + ".a"); }

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
  require_no_include("tests/unit/compare", {"cartesian", "relative"});
}

TEST_CASE("Neither solver links the other, the comparator neither", "[independence]") {
  const auto links = [](const std::string& executable, const std::string& folder) {
    return link_line(executable).find("libconcord_" + folder + ".a") != std::string::npos;
  };
  CHECK(links("tests/unit_cartesian", "cartesian"));
  CHECK_FALSE(links("tests/unit_cartesian", "relative"));
  CHECK_FALSE(links("tests/unit_cartesian", "compare"));
  CHECK(links("tests/unit_relative", "relative"));
  CHECK_FALSE(links("tests/unit_relative", "cartesian"));
  CHECK_FALSE(links("tests/unit_relative", "compare"));
  CHECK(links("tests/unit_compare", "compare"));
  CHECK_FALSE(links("tests/unit_compare", "cartesian"));
  CHECK_FALSE(links("tests/unit_compare", "relative"));
}

TEST_CASE("No library defines or uses symbols of a folder that it must not know", "[independence]") {
  for (const auto& [folder, others] :
       {std::pair<std::string, std::vector<std::string>>{"cartesian", {"relative", "compare"}},
        {"relative", {"cartesian", "compare"}},
        {"compare", {"cartesian", "relative"}},
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

TEST_CASE("Common exports no mass matrix, constraint Jacobian or body kinematics", "[independence]") {
  // A code symbol of namespace concord whose name speaks of the solution rather than of the problem.
  static const std::regex mechanics(
      "mass_matrix|jacobian|kinematic|constraint|velocit|accelerat|gamma\\b|multiplier|coriolis|gyroscop|quadratic|"
      "euler_param|tangent|generalized_force|reaction|projection",
      std::regex::icase);
  const std::string allowed = "concord::guess_poses";  // a first guess from which each solver closes by itself
  std::istringstream lines(symbols_of("common", "--defined-only --extern-only"));
  int checked = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t name = line.find(" concord::");
    if (name == std::string::npos) continue;
    ++checked;
    // Types of the problem may be named by any function's arguments: only the function's own name is looked at.
    const std::string own = line.substr(name, line.find('(', name) - name);
    INFO(line);
    CHECK_FALSE(std::regex_search(own, mechanics));
    CHECK((own.find("pose") == std::string::npos || own.find(allowed) != std::string::npos));
  }
  CHECK(checked > 30);
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
    output_of("cmake -G Ninja -S '" + copy.string() + "' -B " + build + " > /dev/null");
    output_of("ninja -C " + build + " " + target + " > /dev/null");
    const std::string told = output_of(build + "/tests/" + target + " | tail -n 5");
    CHECK(told.find("PASSED") != std::string::npos);
    fs::remove_all(copy);
  }
}
