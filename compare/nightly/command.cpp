#include "compare/nightly/command.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <ostream>
#include <set>

#include "common/error.h"
#include "compare/nightly/baseline.h"
#include "compare/nightly/history.h"
#include "compare/nightly/night.h"
#include "compare/nightly/suite.h"
#include "compare/nightly/tables.h"
#include "compare/report/console.h"
#include "compare/report/files.h"
#include "compare/report/result_folder.h"

namespace concord::compare::nightly {

namespace {

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

/// Throws InputError unless files can be written at the targets, which are none of the inputs and no file twice. Empty
/// paths are none.
void check_targets(const std::vector<fs::path>& targets, std::vector<fs::path> inputs) {
  std::erase(inputs, fs::path());
  for (const fs::path& target : targets) {
    check_output(target, inputs);
    if (!target.empty()) inputs.push_back(target);
  }
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
        scratch_(fs::temp_directory_path()) {}

  int run() {
    check_outputs();
    const Baselines baselines = read_baselines(suite_.baselines);
    History history(command_.history.empty() ? scratch_.path() / "night.sqlite" : command_.history);
    begin(history);
    const auto wall_times = history.wall_times(suite_.name);
    const bool is_complete =
        run_cases(to_run(history), {command_.jobs, command_.minutes}, night_, history, wall_times, makers_, console_);
    const NightReport report = judge(history, baselines);
    // A night that was only a part of the suite is finished too: it is no longer to be resumed.
    // A choice of cases does not end the night that it goes on with.
    if (is_complete && !(is_resumed_ && !command_.only.empty())) history.finish(night_, utc_now());
    const std::string text = format_report(report);
    console_.out << text << std::flush;
    write_outputs(report, text, history);
    notify(report);
    return report.code;
  }

 private:
  void check_outputs() const {
    check_targets({command_.json, command_.junit, command_.markdown},
                  {command_.suite, suite_.baselines, command_.history});
    if (!command_.out.empty()) check_target_folder(command_.out);
    for (const fs::path& stale : {command_.json, command_.junit, command_.markdown}) {
      if (!stale.empty()) fs::remove(stale);
    }
  }

  void begin(History& history) {
    started_ = utc_now();
    if (command_.resume && command_.history.empty()) {
      throw InputError({"--resume", 0, 0}, "only a night that is kept can be resumed: give --history FILE");
    }
    if (command_.resume) {
      if (const auto stopped = history.stopped_night(suite_.name, origin_)) {
        night_ = *stopped;
        history.take_over(night_);
        is_resumed_ = true;
        return;
      }
      console_.err << "nothing to resume: the last night of this suite was finished, was another program's, or is "
                      "running; a new one begins\n";
    }
    night_ = history.begin(suite_.name, fs::absolute(suite_.file).lexically_normal().string(), origin_, started_);
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

  NightReport judge(History& history, const Baselines& baselines) const {
    NightReport report{suite_.name, "concord night", origin_, started_, {}, {}, 0};
    const std::string today = command_.today.empty() ? started_.substr(0, 10) : command_.today;
    for (const Case* one : cases_) {
      const Result result = result_of_case(history, *one);
      const auto baseline = baselines.find(one->id);
      const auto earlier = history.before(night_, suite_.name, one->id, suite_.judging.nights);
      report.cases.push_back(
          case_line_of(result, judge_case(*one, result, baseline == baselines.end() ? nullptr : &baseline->second,
                                          earlier, origin_, suite_.judging, today)));
    }
    if (command_.only.empty() && suite_.judging.against_baseline) add_gone(baselines, report);
    report.code = code_of(report);
    return report;
  }

  Result result_of_case(History& history, const Case& one) const {
    auto result = history.find(night_, one.id);
    if (!result) throw DatabaseError(fmt::format("the history has lost case '{}'", one.id));
    return std::move(*result);
  }

  void add_gone(const Baselines& baselines, NightReport& report) const {
    std::set<std::string> there;
    for (const Case& one : suite_.cases) there.insert(one.id);
    for (const auto& [id, baseline] : baselines) {
      if (there.contains(id)) continue;
      report.others.push_back({Turn::gone, id, "", "case", "in the suite", "not in the suite", "baseline", 1.0, 0});
    }
  }

  void write_json(const fs::path& file, const NightReport& report, History& history) const {
    std::size_t next = 0;
    write_night_json(file, report, [&]() -> std::optional<Result> {
      if (next == cases_.size()) return std::nullopt;
      return result_of_case(history, *cases_[next++]);
    });
  }

  void write_outputs(const NightReport& report, const std::string& text, History& history) const {
    if (!command_.json.empty()) write_json(command_.json, report, history);
    if (!command_.junit.empty()) write_file(command_.junit, format_night_junit(report));
    if (!command_.markdown.empty()) write_file(command_.markdown, format_markdown(report));
    if (command_.out.empty()) return;
    StagedFolder staged(command_.out);
    write_file(staged.path() / "table.txt", text);
    write_file(staged.path() / "regressions.md", format_markdown(report));
    write_file(staged.path() / "junit.xml", format_night_junit(report));
    write_json(staged.path() / "night.json", report, history);
    staged.finish({});
  }

  /// A command that fails is reported, and changes no verdict.
  void notify(const NightReport& report) const {
    if (command_.notify.empty()) return;
    FILE* pipe = popen(command_.notify.c_str(), "w");
    if (pipe == nullptr) throw std::runtime_error("the command of --notify cannot be started");
    const std::string text = format_markdown(report);
    std::fwrite(text.data(), 1, text.size(), pipe);
    const int status = pclose(pipe);
    if (status != 0) console_.err << fmt::format("the command of --notify ended with status {}\n", status);
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
};

/// One side of a difference.
struct DiffSide {
  Origin origin;
  std::vector<Result> results;  // sorted by name
};

const Night& night_called(const std::string& name, const std::vector<Night>& nights) {
  if (nights.empty()) throw InputError({name, 0, 0}, "the history holds no night");
  if (name.starts_with("last")) {
    const std::string back = name.size() > 5 && name[4] == '-' ? name.substr(5) : name.size() == 4 ? "0" : "";
    const bool is_number =
        !back.empty() && back.size() < 9 && back.find_first_not_of("0123456789") == std::string::npos;
    if (is_number && std::stoul(back) < nights.size()) return nights[nights.size() - 1 - std::stoul(back)];
  }
  for (auto night = nights.rbegin(); night != nights.rend(); ++night) {
    if (fmt::format("{}", night->id) == name) return *night;
  }
  for (auto night = nights.rbegin(); night != nights.rend(); ++night) {
    if (name.size() >= 4 && night->origin.commit.starts_with(name)) return *night;
  }
  throw InputError({name, 0, 0},
                   fmt::format("is no file, and the history has no such night: it has {} to {}; \"last\" is the last, "
                               "\"last-1\" the one before; or give the beginning of a commit",
                               nights.front().id, nights.back().id));
}

DiffSide side_called(const std::string& name, const fs::path& history_file) {
  if (history_file.empty() || fs::is_regular_file(name)) {
    NightFile file = read_night_json(name);
    return {file.origin, std::move(file.results)};
  }
  if (!fs::exists(history_file)) throw InputError({history_file.string(), 0, 0}, "there is no such file");
  History history(history_file);
  const std::vector<Night> nights = history.nights();
  const Night& night = night_called(name, nights);
  DiffSide side{night.origin, {}};
  for (const auto& [id, definition] : history.definitions(night.id)) {
    if (auto result = history.find(night.id, id)) side.results.push_back(std::move(*result));
  }
  return side;
}

NightReport difference(const DiffSide& a, const DiffSide& b, const Judging& judging, const DiffCommand& command) {
  NightReport report{
      fmt::format("{} to {}", command.a, command.b), "concord difference", b.origin, utc_now(), {}, {}, 0};
  auto then = a.results.begin();
  auto now = b.results.begin();
  while (then != a.results.end() || now != b.results.end()) {
    const bool only_then = now == b.results.end() || (then != a.results.end() && then->id < now->id);
    const bool only_now = then == a.results.end() || (now != b.results.end() && now->id < then->id);
    if (only_then) {
      report.others.push_back({Turn::gone, then->id, "", "case", to_string(then->ending), "-", "A", 1.0, 0});
      ++then;
    } else if (only_now) {
      report.others.push_back({Turn::fresh, now->id, "", "case", "-", to_string(now->ending), "A", 1.0, 0});
      ++now;
    } else {
      std::vector<Change> changes = changes_between(*then++, *now, judging, "A");
      report.cases.push_back(case_line_of(*now++, std::move(changes)));
    }
  }
  report.code = code_of(report);
  return report;
}

}  // namespace

int run_nightly(const NightlyCommand& command, const SolverMakers& makers, const Console& console) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that grows too large is an error like a full disk
  return guarded(console, [&] { return NightlyRun(command, makers, console).run(); });
}

int show_difference(const DiffCommand& command, const Console& console) {
  return guarded(console, [&] {
    check_targets({command.json, command.junit, command.markdown}, {command.a, command.b, command.history});
    const Judging judging = command.suite.empty() ? Judging() : read_suite(command.suite).judging;
    const DiffSide a = side_called(command.a, command.history);
    const DiffSide b = side_called(command.b, command.history);
    const NightReport report = difference(a, b, judging, command);
    console.out << format_report(report) << std::flush;
    std::size_t next = 0;
    const auto result = [&]() { return next < b.results.size() ? std::optional(b.results[next++]) : std::nullopt; };
    if (!command.json.empty()) write_night_json(command.json, report, result);
    if (!command.junit.empty()) write_file(command.junit, format_night_junit(report));
    if (!command.markdown.empty()) write_file(command.markdown, format_markdown(report));
    return report.code;
  });
}

}  // namespace concord::compare::nightly
