#include "compare/slurm/words.h"

#include <fmt/format.h>
#include <wordexp.h>

#include <array>
#include <sstream>
#include <utility>

#include "common/error.h"

namespace concord::compare::slurm {

namespace {

/// The word behind " Name=" in a line; values that we read hold no spaces.
std::string field(const std::string& line, const std::string& name) {
  const std::string key = ' ' + name + '=';
  const std::size_t begin = (' ' + line).find(key);
  if (begin == std::string::npos) return "";
  const std::size_t value = begin + key.size() - 1;
  const std::string text = line.substr(value, line.find(' ', value) - value);
  return text == "(null)" ? "" : text;
}

/// The indices that "3", "4-10", "4-10%2" and "1,5-7" mean; what is too long for Slurm to print in full ends with
/// "...".
std::vector<int> indices_in(const std::string& text) {
  std::vector<int> indices;
  std::istringstream parts(text.substr(0, text.find('%')));
  for (std::string part; std::getline(parts, part, ',');) {
    int first = 0;
    int last = 0;
    char dash = 0;
    std::istringstream range(part);
    if (!(range >> first)) continue;
    if (!(range >> dash >> last)) last = first;
    for (int k = first; k <= last; ++k) indices.push_back(k);
  }
  return indices;
}

const char* refusal_of(int code) {
  switch (code) {
    case WRDE_BADCHAR:
      return "one of | & ; < > ( ) { } or a line's end stands outside quotes";
    case WRDE_CMDSUB:
      return "a command in it is not run";
    case WRDE_SYNTAX:
      return "a quote or a brace is not closed";
    default:
      return "a shell cannot read it";
  }
}

}  // namespace

std::vector<std::string> split_words(const std::string& text) {
  wordexp_t found{};
  const int code = text.find('\0') != std::string::npos ? WRDE_SYNTAX : wordexp(text.c_str(), &found, WRDE_NOCMD);
  if (code != 0) throw InputError({"--slurm", 0, 0}, fmt::format("'{}': {}", text, refusal_of(code)));
  std::vector<std::string> words(found.we_wordv, found.we_wordv + found.we_wordc);
  wordfree(&found);
  return words;
}

std::string quoted(const std::string& text) {
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + '\'';
}

std::map<int, TaskState> parse_task_states(const std::string& text) {
  std::map<int, TaskState> tasks;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const TaskState state{field(line, "JobState"), field(line, "NodeList"), field(line, "ExitCode")};
    if (state.state.empty()) continue;
    for (const int task : indices_in(field(line, "ArrayTaskId"))) tasks.insert_or_assign(task, state);
  }
  return tasks;
}

std::optional<std::string> state_in_log(const std::string& log) {
  if (log.find("oom-kill") != std::string::npos || log.find("oom_kill") != std::string::npos) return "OUT_OF_MEMORY";
  if (log.find("CANCELLED AT") == std::string::npos) return std::nullopt;
  constexpr std::array<std::pair<const char*, const char*>, 3> kReasons{
      {{"DUE TO TIME LIMIT", "TIMEOUT"}, {"DUE TO NODE FAILURE", "NODE_FAIL"}, {"DUE TO PREEMPTION", "PREEMPTED"}}};
  for (const auto& [sign, state] : kReasons) {
    if (log.find(sign) != std::string::npos) return state;
  }
  return "CANCELLED";
}

std::string words_for(const TaskState& task) {
  static const std::map<std::string, std::string> known{
      {"COMPLETED", "ended, but left no result"}, {"CANCELLED", "was cancelled"},
      {"TIMEOUT", "ran out of its time limit"},   {"NODE_FAIL", "was lost with its node"},
      {"OUT_OF_MEMORY", "ran out of memory"},     {"PREEMPTED", "was stopped for another job"},
      {"DEADLINE", "was not begun in time"},      {"BOOT_FAIL", "was lost: its node did not start"},
      {"PENDING", "waits in the queue"},          {"RUNNING", "is running"},
  };
  const auto words = known.find(task.state);
  std::string text = words == known.end() ? fmt::format("ended as {}", task.state) : words->second;
  if (task.state == "FAILED") {
    const std::size_t colon = task.exit_code.find(':');
    const std::string signal = colon == std::string::npos ? "0" : task.exit_code.substr(colon + 1);
    text = signal == "0" ? fmt::format("failed with exit code {}", task.exit_code.substr(0, colon))
                         : fmt::format("was killed by signal {}", signal);
  }
  const bool is_begun = !task.node.empty() && task.node != "None";
  return is_begun || task.state == "PENDING" || task.state == "DEADLINE" ? text : text + " before it began";
}

}  // namespace concord::compare::slurm
