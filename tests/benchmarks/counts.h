#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "compare/report/origin.h"

/// Instructions and evaluations of jobs, which do not depend on how busy a machine is, against those that were
/// accepted.
namespace concord::benchmarks {

/// What one job takes.
struct Count {
  long instructions = 0;
  long evaluations = 0;  // of a run; zero where they are not told

  friend bool operator==(const Count&, const Count&) = default;
};
using Counts = std::map<std::string, Count, std::less<>>;  // by job

/// By build: compiler and libraries with their versions, "clang 14.0.6, Eigen 3.4.0, ...". Counts of one build say
/// nothing of another's.
using Accepted = std::map<std::string, Counts, std::less<>>;

/// This program's build.
std::string build_of_program();

/// As text that is kept in version control; and back. Throws InputError at the line that is wrong.
std::string format_accepted(const Accepted& accepted);
Accepted parse_accepted(std::string_view text, const std::string& file);

/// From this share on a count is said to have risen or fallen.
inline constexpr double kWorthTelling = 0.03;

/// Counts of a build against those that were accepted.
struct Judgement {
  bool is_compared = true;       // counts of this build were accepted
  std::vector<std::string> red;  // what rose, and jobs of which one of the two is missing: "JOB: OLD -> NEW ..."
  std::vector<std::string> fallen;
};
Judgement judge(const Accepted& accepted, const std::string& build, const Counts& counted);

/// What callgrind and the program wrote in a folder: profile.*, one for each job, and evaluations, "JOB,NUMBER" in each
/// line. Throws InputError where a job lacks either.
Counts read_counts(const std::filesystem::path& folder);

/// Prints what judge() says of a folder against a file; 0: green, 1: red, 77: not compared.
int judge_counts(const std::filesystem::path& folder, const std::filesystem::path& file, std::ostream& out);
/// Makes the counts of a folder those of this build in the file, and writes down beside it who accepted them, and why.
void accept_counts(const std::filesystem::path& folder, const std::filesystem::path& file, const std::string& reason,
                   std::ostream& out);

}  // namespace concord::benchmarks
