#include "compare/nightly/submission.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ostream>
#include <set>
#include <thread>

#include "common/error.h"
#include "compare/nightly/night.h"
#include "compare/report/interrupt.h"
#include "compare/slurm/slurm.h"

namespace concord::compare::nightly {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostTasks = 1000;  // more are a burden to Slurm

/// `concord nightly SUITE OPTION FOLDER` as a command of the shell, by the program that runs now.
std::string job_command(const NightlyCommand& command, const char* option, const fs::path& folder) {
  return fmt::format("exec {} nightly {} {} {}", slurm::quoted(fs::read_symlink("/proc/self/exe").string()),
                     slurm::quoted(command.suite.string()), option, slurm::quoted(folder.string()));
}

/// A name that means nothing else in Slurm's tables.
std::string job_name(const char* what, const NightlyCommand& command) {
  std::string name = fmt::format("concord-{}-{}", what, command.suite.stem().string());
  for (char& c : name) {
    if (static_cast<unsigned char>(c) <= 0x20 || c == '=') c = '_';
  }
  return "--job-name=" + name;
}

/// "--array" of "--array=0-3" and of "-a0-3".
std::string long_name(const std::string& word) {
  constexpr std::array<std::array<const char*, 2>, 6> kShort{{{"-a", "--array"},
                                                              {"-d", "--dependency"},
                                                              {"-o", "--output"},
                                                              {"-e", "--error"},
                                                              {"-D", "--chdir"},
                                                              {"-W", "--wait"}}};
  for (const auto& [letter, name] : kShort) {
    if (word.starts_with(letter)) return name;
  }
  return word.starts_with("--") ? word.substr(0, word.find('=')) : "";
}

/// How many tasks have left a result for each of their cases.
std::size_t finished_tasks(const fs::path& folder, std::size_t tasks) {
  std::size_t finished = 0;
  for (std::size_t k = 0; k < tasks; ++k) {
    const auto record = read_task(folder, static_cast<int>(k));
    finished += record && record->is_finished ? 1 : 0;
  }
  return finished;
}

/// A controller that is started anew does not answer meanwhile. `silent` counts how often it did not.
bool is_alive_with_patience(long job, int& silent) {
  constexpr int kPatience = 120;  // questions
  try {
    const bool is_alive = slurm::is_alive(job);
    silent = 0;
    return is_alive;
  } catch (const slurm::SlurmError&) {
    if (++silent > kPatience) throw;
    return true;
  }
}

int tell_end(const fs::path& folder, const ClusterEnd& end, const Console& console) {
  console.out << end.table << std::flush;
  if (end.table.empty()) {
    console.err << fmt::format("the merge ended with code {}: see {}\n", end.code, (folder / "merge.log").string());
  }
  return end.code;
}

}  // namespace

bool take_slurm_words(std::vector<std::string>& words) {
  const std::set<std::string> own{"--jobs",  "--minutes", "--only",     "--history", "--resume", "--json",
                                  "--junit", "--out",     "--markdown", "--notify",  "--commit"};
  const std::set<std::string> set_here{"--array", "--dependency", "--output",  "--error",
                                       "--chdir", "--wrap",       "--parsable"};
  for (const std::string& word : words) {
    const std::string name = long_name(word);
    if (own.contains(name)) {
      throw InputError({"--slurm", 0, 0},
                       fmt::format("what stands behind it goes to sbatch: write concord's option {} before it", name));
    }
    if (set_here.contains(name)) {
      throw InputError({"--slurm", 0, 0}, fmt::format("concord itself tells sbatch {}: leave it out", name));
    }
  }
  return std::erase_if(words, [](const std::string& word) { return long_name(word) == "--wait"; }) > 0;
}

std::vector<std::vector<const Case*>> deal_cases(std::vector<const Case*> cases, std::size_t most,
                                                 const std::map<std::string, double>& wall_times) {
  put_longest_first(wall_times, cases);
  std::vector<std::vector<const Case*>> tasks(std::min({cases.size(), most, kMostTasks}));
  for (std::size_t k = 0; k < cases.size(); ++k) tasks[k % tasks.size()].push_back(cases[k]);
  return tasks;
}

std::vector<std::string> limits_of_tasks(const std::vector<std::vector<const Case*>>& tasks) {
  constexpr double kMargin = 1.25;  // a case may wait for the disk
  constexpr double kMostMinutes = 525600.0;
  constexpr double kProgram = 512.0;  // megabytes beside the case
  double seconds = 0.0;
  double megabytes = 0.0;
  for (const auto& task : tasks) {
    double sum = 0.0;
    for (const Case* one : task) {
      sum += one->limits.seconds;
      megabytes = std::max(megabytes, one->limits.megabytes);
    }
    seconds = std::max(seconds, sum);
  }
  const double minutes = std::min(std::ceil(kMargin * seconds / 60.0) + 5.0, kMostMinutes);
  return {fmt::format("--time={:.0f}", minutes),
          fmt::format("--mem-per-cpu={:.0f}", std::min(std::ceil(megabytes + kProgram), 1e9))};
}

fs::path cluster_place(const NightlyCommand& command) {
  if (command.history.empty() && command.out.empty()) {
    throw InputError({"--slurm", 0, 0},
                     "the results need a place that every node sees: give --history FILE or --out DIR");
  }
  fs::path place = command.history.empty() ? command.out / "slurm" : command.history;
  if (!command.history.empty()) place += ".slurm";
  return place;
}

long submit_tasks(const fs::path& folder, const NightlyCommand& command,
                  const std::vector<std::vector<const Case*>>& tasks) {
  slurm::Job job{folder, "tasks.sh", job_command(command, "--slurm-task", folder), {"--no-requeue"}, {}, {}};
  const std::vector<std::string> limits = limits_of_tasks(tasks);
  job.defaults.insert(job.defaults.end(), limits.begin(), limits.end());
  job.options = {job_name("tasks", command)};
  if (command.minutes) {
    // A task that has not begun by then does not begin.
    const double limit = std::stod(limits.front().substr(limits.front().find('=') + 1));
    job.options.push_back(fmt::format("--deadline=now+{:.0f}seconds", std::ceil(60.0 * (*command.minutes + limit))));
  }
  job.options.insert(job.options.end(), command.slurm_words.begin(), command.slurm_words.end());
  const std::string at_once = command.jobs > 0 ? fmt::format("%{}", command.jobs) : "";
  job.fixed = {fmt::format("--array=0-{}{}", tasks.size() - 1, at_once), "--output=task-%a.log"};
  return slurm::submit(job);
}

long submit_merge(const fs::path& folder, const NightlyCommand& command, long array) {
  slurm::Job job{folder, "merge.sh", job_command(command, "--slurm-merge", folder), {}, {}, {}};
  job.defaults = {"--time=60", "--mem-per-cpu=2048"};
  job.options = {job_name("merge", command)};
  job.options.insert(job.options.end(), command.slurm_words.begin(), command.slurm_words.end());
  job.fixed = {fmt::format("--dependency=afterany:{}", array), "--output=merge.log"};
  return slurm::submit(job);
}

std::string submission_words(const fs::path& folder, const NightlyCommand& command, const ClusterJobs& jobs,
                             std::size_t cases, std::size_t tasks) {
  std::string places;
  for (const fs::path& place : {command.history, command.out, command.json, command.junit, command.markdown}) {
    if (!place.empty()) places += (places.empty() ? "" : ", ") + place.string();
  }
  std::string text = fmt::format("submitted: {} cases as {} tasks of job {}, then job {} merges their results\n", cases,
                                 tasks, jobs.array, jobs.merge);
  text += fmt::format("results:   {}, when job {} has ended; its table: {}\n", places, jobs.merge,
                      (folder / "merge.log").string());
  text += fmt::format("follow:    squeue --jobs={},{}\n", jobs.array, jobs.merge);
  text += fmt::format("stop:      scancel {} {}", jobs.array, jobs.merge);
  text += command.history.empty() ? "\n" : "; what is done stays, and --resume runs the rest\n";
  const std::string why = slurm::why_it_waits(jobs.array);
  if (why.starts_with("Partition") || why.starts_with("QOS") || why.starts_with("Assoc") || why.starts_with("Req")) {
    text += fmt::format("waits:     {}, says Slurm: the tasks may never begin\n", why);
  }
  return text;
}

int wait_for_merge(const fs::path& folder, const ClusterJobs& jobs, std::size_t tasks, const Console& console) {
  constexpr int kAsk = 30;    // seconds between questions to Slurm
  constexpr int kGrace = 60;  // for a file that a shared file system shows late
  note_progress(
      fmt::format("jobs {} and {} go on: scancel {} {} stops them", jobs.array, jobs.merge, jobs.array, jobs.merge));
  std::size_t told = 0;
  int silent = 0;
  int ended_for = 0;
  for (int second = 1; ended_for <= kGrace; ++second) {
    if (const auto end = read_end(folder)) return tell_end(folder, *end, console);
    std::this_thread::sleep_for(std::chrono::seconds(1));
    if (ended_for > 0) ++ended_for;
    if (ended_for > 0 || second % kAsk != 0) continue;
    if (!is_alive_with_patience(jobs.merge, silent)) ended_for = 1;
    const std::size_t finished = finished_tasks(folder, tasks);
    if (finished != told) console.err << fmt::format("{} of {} tasks done\n", finished, tasks) << std::flush;
    told = finished;
  }
  throw slurm::SlurmError(fmt::format(
      "job {} ended without a verdict: see {}; `concord nightly SUITE --slurm-merge {}` reads what the tasks left",
      jobs.merge, (folder / "merge.log").string(), folder.string()));
}

}  // namespace concord::compare::nightly
