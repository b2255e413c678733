#include <fmt/format.h>

#include <optional>
#include <ostream>

#include "common/error.h"
#include "compare/nightly/command.h"
#include "compare/nightly/history.h"
#include "compare/nightly/night.h"
#include "compare/nightly/suite.h"
#include "compare/nightly/tables.h"
#include "compare/nightly/verdict_file.h"
#include "compare/report/console.h"
#include "compare/report/files.h"
#include "compare/report/result_folder.h"

namespace concord::compare::nightly {

namespace {

namespace fs = std::filesystem;

bool is_counted_from_last(const std::string& name) { return name == "last" || name.starts_with("last-"); }

/// The sides of a difference: files of results, or nights of a history.
class Sides {
 public:
  Sides(const DiffCommand& command, const std::optional<Suite>& suite) : command_(command) {
    if (command.history.empty()) return;
    history_.emplace(command.history, Access::read);
    nights_ = history_->nights();
    suite_ = suite ? suite->name : suite_meant();
  }

  ResultsFile called(const std::string& name) {
    if (!is_night(name)) return read_results_file(name);
    const std::vector<Night> nights = is_counted_from_last(name) ? history_->nights(suite_) : nights_;
    const Night& night = night_called(name, nights);
    ResultsFile side{{night.origin, night.suite, {}, night.only, !night.finished.empty()}, false, false};
    for (const auto& [id, definition] : history_->definitions(night.id)) {
      if (auto result = history_->find(night.id, id)) side.night.results.push_back(std::move(*result));
    }
    return side;
  }

 private:
  [[nodiscard]] bool is_night(const std::string& name) const { return history_ && !fs::is_regular_file(name); }

  /// From whose last night "last-1" is counted, if no suite is given: that of the night on the other side; else that of
  /// the last night of all.
  [[nodiscard]] std::string suite_meant() const {
    for (const std::string& name : {command_.a, command_.b}) {
      if (is_night(name) && !is_counted_from_last(name)) return night_called(name, nights_).suite;
    }
    return nights_.empty() ? "" : nights_.back().suite;
  }

  const DiffCommand& command_;
  std::optional<History> history_;
  std::vector<Night> nights_;  // of all suites
  std::string suite_;
};

/// One side of a difference: what it is called, and how many cases of the other side it never came to.
class Side {
 public:
  Side(const std::string& name, const NightFile& night) : name_(name), night_(night) {}

  /// Takes note of a case that is not in it; returns whether that tells anything: it was asked for it, and is finished.
  bool note_missing(const std::string& id) {
    if (!night_.only.empty() && !is_meant(id, night_.only)) return false;
    if (!night_.is_finished) ++not_run_;
    return night_.is_finished;
  }

  /// Nothing of one that is finished.
  [[nodiscard]] std::string trouble() const {
    if (night_.is_finished) return "";
    return fmt::format("night {} is not finished: of the other side's cases {} not run there", name_,
                       not_run_ == 1 ? "1 was" : fmt::format("{} were", not_run_));
  }

 private:
  const std::string& name_;
  const NightFile& night_;
  int not_run_ = 0;
};

CaseLine new_case(const Result& now) {
  std::vector<Change> changes{{ChangeKind::fresh, now.id, "", "case", "-", to_string(now.ending), "A"}};
  if (!now.is_green()) changes.push_back({ChangeKind::red, now.id, "", "ending", "-", red_words(now)});
  return case_line_of(now, std::move(changes));
}

/// A case of one side alone is gone or new, unless the other side was not asked for it, or did not come to it.
NightReport difference(const NightFile& a, const NightFile& b, const Judging& judging, const DiffCommand& command) {
  NightReport report{
      fmt::format("{} to {}", command.a, command.b), "concord difference", b.origin, utc_now(), {}, {}, 0};
  Side before(command.a, a);
  Side after(command.b, b);
  auto then = a.results.begin();
  auto now = b.results.begin();
  while (then != a.results.end() || now != b.results.end()) {
    const bool only_then = now == b.results.end() || (then != a.results.end() && then->id < now->id);
    const bool only_now = then == a.results.end() || (now != b.results.end() && now->id < then->id);
    if (only_then) {
      if (after.note_missing(then->id)) {
        report.others.push_back({ChangeKind::gone, then->id, "", "case", to_string(then->ending), "-", "A"});
      }
      ++then;
    } else if (only_now) {
      if (before.note_missing(now->id)) report.cases.push_back(new_case(*now));
      ++now;
    } else {
      std::vector<Change> changes = changes_between(*then++, *now, judging, "A");
      report.cases.push_back(case_line_of(*now++, std::move(changes)));
    }
  }
  report.is_finished = a.is_finished && b.is_finished;
  const std::string between = before.trouble().empty() || after.trouble().empty() ? "" : "\n";
  report.trouble = before.trouble() + between + after.trouble();
  report.code = code_of(report);
  return report;
}

}  // namespace

int show_difference(const DiffCommand& command, const Console& console) {
  return guarded(console, [&] {
    check_outputs({command.json, command.junit, command.markdown},
                  {command.a, command.b, command.history, command.suite});
    std::optional<Suite> suite;
    if (!command.suite.empty()) suite = read_suite(command.suite);
    const Judging judging = suite ? suite->judging : Judging();
    Sides sides(command, suite);
    ResultsFile a = sides.called(command.a);
    ResultsFile b = sides.called(command.b);
    require_comparable(a, b, command.a, command.b);
    const NightReport report = difference(a.night, b.night, judging, command);
    console.out << format_report(report) << std::flush;
    std::size_t next = 0;
    const auto result = [&]() {
      return next < b.night.results.size() ? std::optional(b.night.results[next++]) : std::nullopt;
    };
    if (!command.json.empty()) write_night_json(command.json, report, result);
    if (!command.junit.empty()) write_file(command.junit, format_night_junit(report));
    if (!command.markdown.empty()) write_file(command.markdown, format_markdown(report));
    return report.code;
  });
}

}  // namespace concord::compare::nightly
