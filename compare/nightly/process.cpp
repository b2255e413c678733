#include "compare/nightly/process.h"

#include <fmt/format.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "compare/nightly/cluster.h"

namespace concord::compare::nightly {

namespace {

std::string first_line_of(const char* file) {
  std::string line;
  std::getline(std::ifstream(file) >> std::ws, line);
  return line;
}

/// When the process was started, in ticks since the start of the system; empty if there is no such process.
std::string start_of(long process) {
  std::ostringstream text;
  text << std::ifstream(fmt::format("/proc/{}/stat", process)).rdbuf();
  // The name in parentheses may hold anything; the start is the twentieth word after it.
  const std::size_t name_end = text.str().rfind(')');
  if (name_end == std::string::npos) return "";
  std::istringstream words(text.str().substr(name_end + 1));
  std::string word;
  for (int k = 0; k < 20; ++k) words >> word;
  return word;
}

}  // namespace

std::string this_process() {
  return fmt::format("{} {} {}", first_line_of("/proc/sys/kernel/random/boot_id"), getpid(), start_of(getpid()));
}

bool is_running(const std::string& process) {
  if (const auto folder = cluster_folder(process)) return is_cluster_running(*folder);
  std::istringstream words(process);
  std::string system;
  long number = 0;
  std::string start;
  if (!(words >> system >> number)) return false;
  words >> start;
  // Nothing that ran before the system's start runs now.
  if (system != first_line_of("/proc/sys/kernel/random/boot_id")) return false;
  return !start.empty() && start == start_of(number);
}

}  // namespace concord::compare::nightly
