#include "compare/nightly/command.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <memory>
#include <ostream>
#include <set>

#include "common/error.h"
#include "compare/nightly/baseline.h"
#include "compare/nightly/cluster.h"
#include "compare/nightly/history.h"
#include "compare/nightly/judgement.h"
#include "compare/nightly/night.h"
#include "compare/nightly/night_history.h"
#include "compare/nightly/night_page.h"
#include "compare/nightly/notification.h"
#include "compare/nightly/plan.h"
#include "compare/nightly/submission.h"
#include "compare/nightly/suite.h"
#include "compare/nightly/tables.h"
#include "compare/report/console.h"
#include "compare/report/files.h"
#include "compare/report/result_folder.h"
#include "compare/slurm/slurm.h"

namespace concord::compare::nightly {

namespace {

/// What `--out` writes.
constexpr std::array kFilesOfNight{"table.txt", "regressions.md", "junit.xml", "night.html", "night.json"};

namespace fs = std::filesystem;

/// The cases that the pattern means; an empty one means all.
std::vector<const Case*> meant_cases(const Suite& suite, const std::string& pattern) {
  std::vector<const Case*> cases;
  for (const Case& one : suite.cases) {
    if (pattern.empty() || is_meant(one.id, pattern)) cases.push_back(&one);
  }
  if (cases.empty()) throw InputError({suite.file.string(), 0, 0}, fmt::format("no case is called '{}'", pattern));
  return cases;
}

/// Pages of single cases in a folder.
std::set<std::string> names_of_pages(const fs::path& folder) {
  std::set<std::string> names;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("case_") && name.ends_with(".html")) names.insert(name);
  }
  return names;
}

/// One run of `concord nightly`.
class NightlyRun {
 public:
  NightlyRun(const NightlyCommand& command, const SolverMakers& makers, const Console& console)
      : command_(command),
        makers_(makers),
        console_(console),
        suite_(read_suite(command.suite)),
        origin_(origin_of_program(command.commit)),
        cases_(meant_cases(suite_, command.only)),
        scratch_(scratch_place()) {}

  int run() {
    return notified([&] { return run_here(); });
  }

  /// What the merge job does: reads what the tasks left, and reports.
  int merge(const fs::path& folder, const ClusterPlan& plan) {
    return notified([&] { return merge_here(folder, plan); });
  }

  /// The same by the jobs of a cluster, which do not begin before all is known to be in order.
  int submit() {
    const fs::path place = cluster_place(command_);
    check_outputs();
    check_target_folder(place);
    const Baselines baselines = read_baselines(suite_.baselines);
    const slurm::Cluster cluster = slurm::find_cluster();
    origin_.machine = cluster_machine(cluster.name);
    std::optional<NightHistory> history = night_history();
    started_ = utc_now();
    resume(history->get());
    const std::vector<const Case*> cases = to_run(history->get());
    if (cases.empty()) return conclude(*history, baselines, true).code;
    const auto tasks =
        deal_cases(cases, static_cast<std::size_t>(cluster.most_tasks), history->get().wall_times(suite_.name));
    const fs::path folder = make_numbered_folder(place);
    ClusterJobs jobs;
    try {
      ClusterPlan plan = plan_of(tasks);
      write_plan(folder, plan);
      jobs.array = submit_tasks(folder, command_, tasks);
      write_jobs(folder, jobs);
      if (!is_resumed_) begin(history->get());
      history->get().take_over(night_, cluster_process(folder));
      if (!command_.history.empty()) plan.night = night_;
      write_plan(folder, plan);
      // From now on the history is the merge's: no two computers may use it at a time.
      history.reset();
      jobs.merge = submit_merge(folder, command_, jobs.array);
    } catch (...) {
      withdraw(folder, jobs.array);
      throw;
    }
    write_jobs(folder, jobs);
    std::ostream& told = command_.wait ? console_.err : console_.out;
    told << submission_words(folder, command_, jobs, cases.size(), tasks.size()) << std::flush;
    return command_.wait ? wait_for_merge(folder, jobs, tasks.size(), console_) : static_cast<int>(kAgree);
  }

 private:
  int run_here() {
    check_outputs();
    const Baselines baselines = read_baselines(suite_.baselines);
    NightHistory history = night_history();
    started_ = utc_now();
    if (!resume(history.get())) begin(history.get());
    const auto wall_times = history.get().wall_times(suite_.name);
    const auto store = [&](const Result& result) { history.store(night_, result); };
    const bool is_complete = run_cases(to_run(history.get()), {command_.jobs, command_.minutes, pages()}, store,
                                       wall_times, makers_, console_);
    return conclude(history, baselines, is_complete).code;
  }

  int merge_here(const fs::path& folder, const ClusterPlan& plan) {
    check_outputs();
    const Baselines baselines = read_baselines(suite_.baselines);
    NightHistory history = night_history();
    started_ = plan.started;
    origin_ = plan.origin;
    is_resumed_ = plan.is_resumed;
    night_ = plan.night;
    if (night_ == 0) begin(history.get());
    const bool is_complete = merge_tasks(folder, plan, cases_, night_, history.get(), console_);
    const ClusterEnd end = conclude(history, baselines, is_complete);
    write_end(folder, end);
    if (is_complete) remove_task_files(folder, plan.tasks.size());
    return end.code;
  }

  /// What ends a night without a report is told as its verdict would be.
  template <class Work>
  int notified(const Work& work) const {
    try {
      return work();
    } catch (const std::exception& error) {
      if (!is_reported_) notify_of_end(command_, suite_.name, error.what(), console_);
      throw;
    }
  }

  /// Where the pages of red cases stand until the night's results do.
  fs::path pages() const { return command_.out.empty() ? fs::path() : scratch_.path() / "pages"; }

  fs::path history_file() const {
    return command_.history.empty() ? scratch_.path() / "night.sqlite" : command_.history;
  }

  NightHistory night_history() const { return {history_file(), scratch_.path() / "copy.sqlite"}; }

  /// When all cases were run, or are known not to be.
  ClusterEnd conclude(NightHistory& history, const Baselines& baselines, bool is_complete) {
    // A night that was only a part of the suite is finished too: it is no longer to be resumed.
    // A choice of cases does not end the night that it goes on with.
    if (is_complete && !(is_resumed_ && !command_.only.empty())) history.finish(night_, utc_now());
    const NightReport report = judge(history, baselines);
    const std::string text = format_report(report);
    console_.out << text << std::flush;
    write_outputs(report, text, history.get());
    is_reported_ = true;
    notify(command_, format_markdown(report), console_);
    return {report.code, text, is_complete};
  }

  ClusterPlan plan_of(const std::vector<std::vector<const Case*>>& tasks) const {
    ClusterPlan plan{
        build_words(), command_, fs::current_path(), origin_, started_, static_cast<long>(std::time(nullptr)), 0,
        is_resumed_,   {}};
    for (const auto& task : tasks) {
      std::vector<std::string>& names = plan.tasks.emplace_back();
      for (const Case* one : task) names.push_back(one->id);
    }
    return plan;
  }

  /// After a submission that did not succeed.
  void withdraw(const fs::path& folder, long array) const {
    if (array != 0) slurm::cancel(array);
    if (!is_resumed_ && night_ != 0) History(history_file()).withdraw(night_);
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    fs::remove(folder.parent_path(), ignored);  // unless other nights are there
  }

  void check_outputs() const {
    std::vector<fs::path> files{command_.suite, suite_.baselines, log_of(suite_.baselines), command_.history};
    for (const Case& one : suite_.cases) files.push_back(one.model);
    std::sort(files.begin(), files.end());
    files.erase(std::unique(files.begin(), files.end()), files.end());
    const InputFiles inputs(std::move(files));
    compare::check_outputs({command_.json, command_.junit, command_.markdown, command_.report}, inputs);
    check_results(command_.out, {kFilesOfNight.begin(), kFilesOfNight.end()}, inputs);
    for (const fs::path& stale : {command_.json, command_.junit, command_.markdown, command_.report}) {
      if (!stale.empty()) fs::remove(stale);
    }
    if (command_.out.empty()) return;
    for (const char* stale : kFilesOfNight) fs::remove(command_.out / stale);
  }

  /// Whether a stopped night goes on; it must be wished.
  bool resume(History& history) {
    if (!command_.resume) return false;
    if (command_.history.empty()) {
      throw InputError({"--resume", 0, 0}, "only a night that is kept can be resumed: give --history FILE");
    }
    const auto stopped = history.stopped_night(suite_.name, origin_);
    if (!stopped || is_of_another_file(*stopped)) {
      console_.err << "nothing to resume: the last night of this suite was finished, was another program's or another "
                      "suite file's, or is running; a new one begins\n";
      return false;
    }
    if (!stopped->only.empty() && !command_.only.empty() && stopped->only != command_.only) {
      throw InputError(
          {"--only", 0, 0},
          fmt::format("the stopped night was asked for '{}': resume it for these, or for all", stopped->only));
    }
    night_ = stopped->id;
    is_resumed_ = true;
    // A merge that was lost has not read what the tasks left.
    const auto folder = cluster_folder(history.process_of(night_));
    if (folder && fs::exists(*folder / "plan.json") && !read_end(*folder)) {
      store_task_results(*folder, read_plan(*folder), cases_, night_, history);
    }
    history.take_over(night_);
    if (command_.only.empty()) history.ask_for_all(night_);
    return true;
  }

  /// Of a suite that only has the same name: its file is still there and says something else. A suite may be moved, and
  /// may lie in several checkouts.
  bool is_of_another_file(const Night& earlier) const {
    const std::uint64_t hash = hash_of_file(earlier.suite_file);
    return hash != 0 && hash != hash_of_file(suite_.file);
  }

  /// Two suites of one name in one history are each other's past.
  void tell_of_namesake(History& history) const {
    const std::vector<Night> nights = history.nights(suite_.name);
    if (nights.empty() || !is_of_another_file(nights.back())) return;
    console_.err << fmt::format(
        "note: the last night of '{}' in this history was that of {}: each is the other's past, "
        "unless one of them is given another name\n",
        suite_.name, nights.back().suite_file);
  }

  void begin(History& history) {
    tell_of_namesake(history);
    night_ = history.begin(suite_.name, night().suite_file, origin_, started_, command_.only);
  }

  /// Without those that the night had already, if they were asked the same.
  std::vector<const Case*> to_run(History& history) const {
    if (!is_resumed_) return cases_;
    const auto done = history.definitions(night_);
    std::vector<const Case*> left;
    for (const Case* one : cases_) {
      const auto found = done.find(one->id);
      if (found == done.end() || found->second != definition_of(*one)) left.push_back(one);
    }
    console_.err << fmt::format("night {} goes on: {} of {} cases were done\n", night_, cases_.size() - left.size(),
                                cases_.size());
    return left;
  }

  Night night() const {
    return {night_,  suite_.name,  fs::absolute(suite_.file).lexically_normal().string(), started_, "",
            origin_, command_.only};
  }

  NightReport judge(NightHistory& history, const Baselines& baselines) const {
    const std::string today = command_.today.empty() ? started_.substr(0, 10) : command_.today;
    NightReport report = judge_night(history.get(), night(), cases_, baselines, suite_.judging, today);
    report.trouble = history.trouble();
    if (command_.only.empty()) add_gone(suite_, baselines, report);
    report.code = code_of(report);
    return report;
  }

  void write_json(const fs::path& file, const NightReport& report, History& history) const {
    std::size_t next = 0;
    write_night_json(file, report, [&]() -> std::optional<Result> {
      if (next == cases_.size()) return std::nullopt;
      return result_of_case(history, night_, cases_[next++]->id);
    });
  }

  void write_outputs(const NightReport& report, const std::string& text, History& history) const {
    if (!command_.json.empty()) write_json(command_.json, report, history);
    if (!command_.junit.empty()) write_file(command_.junit, format_night_junit(report));
    if (!command_.markdown.empty()) write_file(command_.markdown, format_markdown(report));
    if (!command_.report.empty()) write_file(command_.report, format_page(report, history, {}));
    if (command_.out.empty()) return;
    const std::set<std::string> pages = names_of_pages(this->pages());
    const std::set<std::string> old = names_of_pages(command_.out);
    StagedFolder staged(command_.out);
    for (const std::string& name : pages) fs::copy_file(this->pages() / name, staged.path() / name);
    const auto& [table, regressions, junit, page_file, json] = kFilesOfNight;
    write_file(staged.path() / table, text);
    write_file(staged.path() / regressions, format_markdown(report));
    write_file(staged.path() / junit, format_night_junit(report));
    write_file(staged.path() / page_file, format_page(report, history, pages));
    write_json(staged.path() / json, report, history);
    staged.finish({old.begin(), old.end()});
  }

  std::string format_page(const NightReport& report, History& history, const std::set<std::string>& pages) const {
    NightPage page{report, night(), suite_.judging, 100, {}, pages};
    if (command_.history.empty()) page.notes.emplace_back("Without a history this night alone is known: no trend.");
    if (!report.trouble.empty()) page.notes.push_back(report.trouble);
    return format_night_page(page, history);
  }

  const NightlyCommand& command_;
  const SolverMakers& makers_;
  const Console& console_;
  Suite suite_;
  Origin origin_;
  std::vector<const Case*> cases_;
  StagedFolder scratch_;
  std::string started_;
  long night_ = 0;
  bool is_resumed_ = false;
  bool is_reported_ = false;
};

/// A night; a suite that cannot be read is told, too.
template <class Work>
int with_night(const NightlyCommand& command, const SolverMakers& makers, const Console& console, const Work& work) {
  std::optional<NightlyRun> night;
  try {
    night.emplace(command, makers, console);
  } catch (const std::exception& error) {
    notify_of_end(command, command.suite.string(), error.what(), console);
    throw;
  }
  return work(*night);
}

/// A merge that cannot report leaves its code, for who waits.
int merge_night(const fs::path& folder, const SolverMakers& makers, const Console& console) {
  std::optional<ClusterPlan> plan;
  const int code = guarded(console, [&] {
    plan = read_plan(folder);
    if (const auto end = read_end(folder); end && end->is_complete) {
      throw InputError({folder.string(), 0, 0}, "the results of this night are merged already: all tasks were done");
    }
    fs::current_path(plan->where);
    return with_night(plan->command, makers, console, [&](NightlyRun& night) { return night.merge(folder, *plan); });
  });
  if (plan && !read_end(folder)) {
    guarded(console, [&] { write_end(folder, {code, "", false}); });
  }
  return code;
}

int submit_night(NightlyCommand command, const SolverMakers& makers, const Console& console) {
  return guarded(console, [&] {
    const std::vector<std::string> more = slurm::split_words(command.slurm_text);
    command.slurm_words.insert(command.slurm_words.begin(), more.begin(), more.end());
    if (take_slurm_words(command.slurm_words)) command.wait = true;
    // Jobs do not run where the user stands.
    for (fs::path* path :
         {&command.history, &command.json, &command.junit, &command.markdown, &command.report, &command.out}) {
      if (!path->empty()) *path = fs::absolute(*path).lexically_normal();
    }
    return with_night(command, makers, console, [](NightlyRun& night) { return night.submit(); });
  });
}

}  // namespace

int run_nightly(const NightlyCommand& command, const SolverMakers& makers, const Console& console) {
  if (!command.slurm_task.empty()) return guarded(console, [&] { return run_cluster_task(command, makers, console); });
  if (!command.slurm_merge.empty()) return merge_night(fs::absolute(command.slurm_merge), makers, console);
  if (command.slurm) return submit_night(command, makers, console);
  return guarded(console,
                 [&] { return with_night(command, makers, console, [](NightlyRun& night) { return night.run(); }); });
}

}  // namespace concord::compare::nightly
