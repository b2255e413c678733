#include "compare/nightly/cluster.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <limits>
#include <ostream>
#include <set>
#include <sstream>
#include <thread>

#include "common/error.h"
#include "compare/nightly/night.h"
#include "compare/nightly/suite.h"
#include "compare/report/interrupt.h"
#include "compare/slurm/slurm.h"

namespace concord::compare::nightly {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kClusterProcess = "slurm ";
constexpr std::string_view kClusterMachine = "Slurm cluster ";
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

long task_number() {
  const char* text = std::getenv("SLURM_ARRAY_TASK_ID");
  const std::string number = text == nullptr ? "" : text;
  if (number.empty() || number.size() > 9 || number.find_first_not_of("0123456789") != std::string::npos) {
    throw InputError({"--slurm-task", 0, 0},
                     "is what a task of a job array is started with: SLURM_ARRAY_TASK_ID is "
                     "no number");
  }
  return std::stol(number);
}

/// Processors that Slurm gave the task on this node.
int task_processors() {
  const char* text = std::getenv("SLURM_CPUS_ON_NODE");
  return text == nullptr ? 1 : std::clamp(std::atoi(text), 1, 1024);
}

std::string text_of_log(const fs::path& folder, int task) {
  const fs::path file = folder / task_log_name(task);
  std::ifstream log(file, std::ios::binary);
  std::ostringstream text;
  text << log.rdbuf();
  return text.str();
}

std::string last_line_of(const std::string& text) {
  const std::size_t end = text.find_last_not_of("\n ");
  if (end == std::string::npos) return "";
  const std::size_t begin = text.rfind('\n', end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1,
                     end - (begin == std::string::npos ? 0 : begin + 1) + 1);
}

/// What became of a task that has not done all of its cases.
std::string words_of_lost(const fs::path& folder, int task, const std::optional<TaskRecord>& record,
                          const std::map<int, slurm::TaskState>& states) {
  const std::string log = text_of_log(folder, task);
  const auto known = states.find(task);
  slurm::TaskState state = known == states.end() ? slurm::TaskState() : known->second;
  if (known == states.end()) state.state = slurm::state_in_log(log).value_or("");
  if (record && state.node.empty()) state.node = record->node;
  const std::string where = state.node.empty() ? "" : " on " + state.node;
  if (state.state.empty()) {
    return fmt::format("lost: task {}{} left no result, and Slurm does not know the task any more", task, where);
  }
  std::string words = fmt::format("lost: task {}{} {}", task, where, slurm::words_for(state));
  if (state.state == "FAILED" && !last_line_of(log).empty()) words += ": " + last_line_of(log);
  return words;
}

Result not_run(const Case& one, const std::string& words) {
  Result result;
  result.id = one.id;
  result.work = work_names()[static_cast<std::size_t>(one.work)];
  result.words = words;
  return result;
}

/// All that the tasks left, and what is to be said of their other cases; by name.
struct Left {
  std::map<std::string, Result> results;
  std::map<std::string, std::string> lost;
  int lost_tasks = 0;
};

/// A shared file system may show a file some seconds after it was written on another node.
void await_records(const fs::path& folder, const std::map<int, slurm::TaskState>& states) {
  constexpr int kPatience = 60;  // seconds
  for (int second = 0; second < kPatience; ++second) {
    const bool is_late = std::any_of(states.begin(), states.end(), [&](const auto& task) {
      if (task.second.state != "COMPLETED") return false;
      const auto record = read_task(folder, task.first);
      return !record || !record->is_finished;
    });
    if (!is_late) return;
    std::this_thread::sleep_for(std::chrono::seconds(1));
  }
}

Left what_tasks_left(const fs::path& folder, const ClusterPlan& plan, const std::map<int, slurm::TaskState>& states) {
  Left left;
  for (std::size_t k = 0; k < plan.tasks.size(); ++k) {
    const int task = static_cast<int>(k);
    const auto record = read_task(folder, task);
    for (const Result& result : record ? record->results : std::vector<Result>())
      left.results.emplace(result.id, result);
    const bool has_all = std::all_of(plan.tasks[k].begin(), plan.tasks[k].end(),
                                     [&](const std::string& name) { return left.results.contains(name); });
    if (has_all) continue;
    const bool is_finished = record && record->is_finished;
    if (!is_finished) ++left.lost_tasks;
    const std::string words = !is_finished           ? words_of_lost(folder, task, record, states)
                              : plan.command.minutes ? "the time of the night was up"
                                                     : "interrupted, and its task went on";
    for (const std::string& name : plan.tasks[k]) {
      if (!left.results.contains(name)) left.lost.emplace(name, words);
    }
  }
  return left;
}

}  // namespace

std::string cluster_process(const fs::path& folder) { return std::string(kClusterProcess) + folder.string(); }

std::optional<fs::path> cluster_folder(const std::string& process) {
  if (!process.starts_with(kClusterProcess)) return std::nullopt;
  return fs::path(process.substr(kClusterProcess.size()));
}

bool is_cluster_running(const fs::path& folder) {
  const ClusterJobs jobs = read_jobs(folder);
  return (jobs.array != 0 && slurm::is_alive(jobs.array)) || (jobs.merge != 0 && slurm::is_alive(jobs.merge));
}

std::string cluster_machine(const std::string& name) { return std::string(kClusterMachine) + name; }
bool is_cluster_machine(const std::string& machine) { return machine.starts_with(kClusterMachine); }

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

int wait_for_merge(const fs::path& folder, const ClusterJobs& jobs, const Console& console) {
  constexpr int kAsk = 30;    // seconds between questions to Slurm
  constexpr int kGrace = 60;  // for a file that a shared file system shows late
  note_progress(
      fmt::format("jobs {} and {} go on: scancel {} {} stops them", jobs.array, jobs.merge, jobs.array, jobs.merge));
  int ended_for = 0;
  for (int second = 1;; ++second) {
    if (const auto end = read_end(folder)) {
      console.out << end->table << std::flush;
      if (end->table.empty()) {
        console.err << fmt::format("the merge ended with code {}: see {}\n", end->code,
                                   (folder / "merge.log").string());
      }
      return end->code;
    }
    std::this_thread::sleep_for(std::chrono::seconds(1));
    if (ended_for == 0 && second % kAsk != 0) continue;
    if (ended_for == 0 && slurm::is_alive(jobs.merge)) continue;
    if (++ended_for > kGrace) break;
  }
  throw slurm::SlurmError(fmt::format(
      "job {} ended without a verdict: see {}; `concord nightly SUITE --slurm-merge {}` reads what the tasks left",
      jobs.merge, (folder / "merge.log").string(), folder.string()));
}

int run_cluster_task(const NightlyCommand& command, const SolverMakers& makers, const Console& console) {
  const fs::path folder = fs::absolute(command.slurm_task);
  const ClusterPlan plan = read_plan(folder);
  if (plan.program != build_words()) {
    throw InputError(
        {folder.string(), 0, 0},
        fmt::format("the night was submitted by another program: by {}, not by {}", plan.program, build_words()));
  }
  const long task = task_number();
  if (static_cast<std::size_t>(task) >= plan.tasks.size()) {
    throw InputError({folder.string(), 0, 0},
                     fmt::format("has {} tasks, and none of number {}", plan.tasks.size(), task));
  }
  std::set<std::string> to_run(plan.tasks[task].begin(), plan.tasks[task].end());
  TaskRecord record = read_task(folder, static_cast<int>(task)).value_or(TaskRecord());
  for (const Result& done : record.results) to_run.erase(done.id);
  const char* node = std::getenv("SLURMD_NODENAME");
  record.node = node == nullptr ? "" : node;
  write_task(folder, static_cast<int>(task), record);
  fs::current_path(plan.where);
  const Suite suite = read_suite(plan.command.suite);
  std::vector<const Case*> cases;
  for (const Case& one : suite.cases) {
    if (to_run.contains(one.id)) cases.push_back(&one);
  }
  NightOptions options{task_processors(), plan.command.minutes};
  if (options.minutes) *options.minutes -= static_cast<double>(std::time(nullptr) - plan.started_s) / 60.0;
  const auto store = [&](const Result& result) {
    if (result.ending == Ending::not_run) return;  // the merge says why
    record.results.push_back(result);
    write_task(folder, static_cast<int>(task), record);
  };
  run_cases(cases, options, store, {}, makers, console);
  record.is_finished = true;
  write_task(folder, static_cast<int>(task), record);
  return kAgree;
}

int store_task_results(const fs::path& folder, const ClusterPlan& plan, const std::vector<const Case*>& cases,
                       long night, History& history) {
  const Left left = what_tasks_left(folder, plan, {});
  int stored = 0;
  for (const Case* one : cases) {
    const auto found = left.results.find(one->id);
    if (found == left.results.end()) continue;
    history.store(night, found->second);
    ++stored;
  }
  return stored;
}

bool merge_tasks(const fs::path& folder, const ClusterPlan& plan, const std::vector<const Case*>& cases, long night,
                 History& history, const Console& console) {
  const long array = read_jobs(folder).array;
  const auto states = array == 0 ? std::map<int, slurm::TaskState>() : slurm::task_states(array);
  await_records(folder, states);
  const Left left = what_tasks_left(folder, plan, states);
  bool is_complete = true;
  for (const Case* one : cases) {
    const auto found = left.results.find(one->id);
    const auto lost = left.lost.find(one->id);
    if (found != left.results.end()) {
      history.store(night, found->second);
    } else if (lost != left.lost.end()) {
      history.store(night, not_run(*one, lost->second));
      is_complete = false;
    } else if (!history.find(night, one->id)) {
      history.store(night, not_run(*one, "it was not in the suite when the night was submitted"));
      is_complete = false;
    }
  }
  console.err << fmt::format("{} tasks: {} left all their results, {} were lost\n", plan.tasks.size(),
                             plan.tasks.size() - static_cast<std::size_t>(left.lost_tasks), left.lost_tasks);
  return is_complete;
}

}  // namespace concord::compare::nightly
