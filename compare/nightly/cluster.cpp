#include "compare/nightly/cluster.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <ostream>
#include <set>
#include <sstream>
#include <thread>

#include "common/error.h"
#include "compare/nightly/night.h"
#include "compare/nightly/suite.h"
#include "compare/report/whole_number.h"
#include "compare/slurm/slurm.h"

namespace concord::compare::nightly {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kClusterProcess = "slurm ";
constexpr std::string_view kClusterMachine = "Slurm cluster ";

int task_number() {
  const char* text = std::getenv("SLURM_ARRAY_TASK_ID");
  const auto number = whole_text_as<int>(text == nullptr ? "" : text);
  if (!number || *number < 0) {
    throw InputError({"--slurm-task", 0, 0},
                     "is what a task of a job array is started with: SLURM_ARRAY_TASK_ID is "
                     "no number");
  }
  return *number;
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

/// Whether the night knows how the case ended: that was found before, or by another task.
bool has_result(History& history, long night, const std::string& id) {
  const auto found = history.find(night, id);
  return found && found->ending != Ending::not_run;
}

/// All that the tasks left, and what is to be said of their other cases; by name.
struct Left {
  std::map<std::string, Result> results;
  std::map<std::string, std::string> lost;
  int lost_tasks = 0;
  int stopped_tasks = 0;  // ended in order, without all of their cases
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
    ++(is_finished ? left.stopped_tasks : left.lost_tasks);
    const std::string words = !is_finished           ? words_of_lost(folder, task, record, states)
                              : plan.command.minutes ? kTimeIsUp
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
  if (read_end(folder)) return false;  // merged; Slurm need not be there any more
  const ClusterJobs jobs = read_jobs(folder);
  return (jobs.array != 0 && slurm::is_alive(jobs.array)) || (jobs.merge != 0 && slurm::is_alive(jobs.merge));
}

std::string cluster_machine(const std::string& name) { return std::string(kClusterMachine) + name; }
bool is_cluster_machine(const std::string& machine) { return machine.starts_with(kClusterMachine); }

int run_cluster_task(const NightlyCommand& command, const SolverMakers& makers, const Console& console) {
  const fs::path folder = fs::absolute(command.slurm_task);
  const ClusterPlan plan = read_plan(folder);
  if (plan.program != build_words()) {
    throw InputError({"concord", 0, 0}, fmt::format("was built anew since the night was submitted: by {}, now {}",
                                                    plan.program, build_words()));
  }
  const int task = task_number();
  if (static_cast<std::size_t>(task) >= plan.tasks.size()) {
    throw InputError({folder.string(), 0, 0},
                     fmt::format("has {} tasks, and none of number {}", plan.tasks.size(), task));
  }
  std::set<std::string> to_run(plan.tasks[task].begin(), plan.tasks[task].end());
  TaskRecord record = read_task(folder, task).value_or(TaskRecord());
  for (const Result& done : record.results) to_run.erase(done.id);
  const char* node = std::getenv("SLURMD_NODENAME");
  record.node = node == nullptr ? "" : node;
  write_task(folder, task, record);
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
    write_task(folder, task, record);
  };
  run_cases(cases, options, store, {}, makers, console);
  record.is_finished = true;
  write_task(folder, task, record);
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
    } else if (!has_result(history, night, one->id)) {
      history.store(night,
                    not_run(*one, lost != left.lost.end() ? lost->second
                                                          : "it was not in the suite when the night was submitted"));
      is_complete = false;
    }
  }
  const auto all = static_cast<int>(plan.tasks.size());
  console.err << fmt::format(
      "{} tasks: {} left all their results, {} were lost{}\n", all, all - left.lost_tasks - left.stopped_tasks,
      left.lost_tasks,
      left.stopped_tasks > 0 ? fmt::format(", {} stopped before their end", left.stopped_tasks) : std::string());
  return is_complete;
}

}  // namespace concord::compare::nightly
