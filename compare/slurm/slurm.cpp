#include "compare/slurm/slurm.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <sstream>

#include "common/error.h"
#include "compare/report/files.h"
#include "compare/report/whole_number.h"
#include "compare/slurm/words.h"

namespace concord::compare::slurm {

namespace {

constexpr int kNoSuchCommand = 127;  // of the shell

struct Said {
  int code = 0;
  std::string text;  // both streams
};

/// Runs a command of the shell.
Said run(const std::string& command) {
  FILE* pipe = popen((command + " 2>&1 </dev/null").c_str(), "r");
  if (pipe == nullptr) throw SlurmError("no shell can be started");
  Said said;
  std::array<char, 4096> chunk{};
  for (std::size_t got = fread(chunk.data(), 1, chunk.size(), pipe); got > 0;
       got = fread(chunk.data(), 1, chunk.size(), pipe)) {
    said.text.append(chunk.data(), got);
  }
  const int status = pclose(pipe);
  said.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  while (!said.text.empty() && said.text.back() == '\n') said.text.pop_back();
  return said;
}

/// The value of a line "Name = value".
std::string setting(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos || !line.starts_with(name + ' ')) continue;
    const std::size_t value = line.find_first_not_of(" \t", equals + 1);
    return value == std::string::npos ? "" : line.substr(value);
  }
  return "";
}

/// The job's number in what `sbatch --parsable` prints: "18" or "18;cluster" on a line of its own.
std::optional<long> number_in(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const auto number = whole_text_as<long>(line.substr(0, line.find(';')));
    if (number && *number >= 0) return number;
  }
  return std::nullopt;
}

/// A refusal is answered by other options, an unreachable controller by patience.
bool is_unreachable(const std::string& text) {
  constexpr std::array kSigns{"Unable to contact",           "timed out",
                              "Connection refused",          "temporarily unable",
                              "Zero Bytes were transmitted", "Protocol authentication error"};
  return std::any_of(kSigns.begin(), kSigns.end(),
                     [&](const char* sign) { return text.find(sign) != std::string::npos; });
}

std::string script_of(const Job& job) {
  std::string text = "#!/bin/sh\n";
  for (const std::string& option : job.defaults) text += fmt::format("#SBATCH {}\n", option);
  return text + job.command + '\n';
}

}  // namespace

Cluster find_cluster() {
  const Said sbatch = run("command -v sbatch && command -v scontrol && command -v squeue");
  if (sbatch.code != 0) {
    throw InputError({"--slurm", 0, 0},
                     "there is no Slurm on this machine (sbatch, scontrol and squeue are looked for in PATH): start it "
                     "where jobs are submitted");
  }
  const Said said = run("scontrol show config");
  if (said.code != 0) throw SlurmError(fmt::format("Slurm does not answer: {}", said.text));
  const Cluster cluster{setting(said.text, "ClusterName"),
                        whole_text_as<int>(setting(said.text, "MaxArraySize")).value_or(0)};
  if (cluster.most_tasks < 1) throw InputError({"--slurm", 0, 0}, "this Slurm allows no job arrays: MaxArraySize is 0");
  return cluster;
}

long submit(const Job& job) {
  write_file(job.folder / job.script, script_of(job));
  std::string command = fmt::format("cd {} && exec sbatch --parsable", quoted(job.folder.string()));
  for (const auto* options : {&job.options, &job.fixed}) {
    for (const std::string& option : *options) command += ' ' + quoted(option);
  }
  const Said said = run(fmt::format("{} --chdir={} {}", command, quoted(job.folder.string()), quoted(job.script)));
  const auto number = said.code == 0 ? number_in(said.text) : std::nullopt;
  if (number) return *number;
  if (said.code == kNoSuchCommand) throw InputError({"sbatch", 0, 0}, "cannot be started: " + said.text);
  if (said.code == 0)
    throw SlurmError(fmt::format("sbatch submitted no job, or did not tell its number: {}", said.text));
  if (is_unreachable(said.text)) throw SlurmError(fmt::format("sbatch cannot submit: {}", said.text));
  throw InputError({"sbatch", 0, 0}, fmt::format("refuses the job: {}", said.text));
}

void cancel(long job) { static_cast<void>(run(fmt::format("scancel {}", job))); }

bool is_alive(long job) {
  const Said said = run(fmt::format("squeue --noheader --jobs={} --format=%T", job));
  if (said.code == 0) return !said.text.empty();
  // Told of jobs that have ended and of those that never were.
  if (said.text.find("Invalid job id") != std::string::npos) return false;
  throw SlurmError(fmt::format("squeue does not tell whether job {} runs: {}", job, said.text));
}

std::string why_it_waits(long job) {
  const Said said = run(fmt::format("squeue --noheader --states=PENDING --jobs={} --format=%r", job));
  return said.code == 0 ? said.text.substr(0, said.text.find('\n')) : "";
}

std::map<int, TaskState> task_states(long array) {
  const Said said = run(fmt::format("scontrol --oneliner show job {}", array));
  return said.code == 0 ? parse_task_states(said.text) : std::map<int, TaskState>();
}

}  // namespace concord::compare::slurm
