#include <fmt/format.h>

#include <list>
#include <optional>

#include "common/error.h"
#include "compare/nightly/baseline.h"
#include "compare/nightly/command.h"
#include "compare/nightly/history.h"
#include "compare/nightly/judgement.h"
#include "compare/nightly/night_page.h"
#include "compare/nightly/suite.h"
#include "compare/nightly/tables.h"
#include "compare/report/console.h"
#include "compare/report/files.h"
#include "compare/report/result_folder.h"

namespace concord::compare::nightly {

namespace {

namespace fs = std::filesystem;

/// By what a night that is over is judged.
struct Yardstick {
  std::optional<Suite> suite;
  Judging judging;
  std::string words;
};

/// The suite that is asked for must be there; the one that the night had may be gone or changed.
Yardstick yardstick_for(const NightReportCommand& command, const Night& night) {
  Yardstick found;
  const auto take = [&](const fs::path& file) {
    found.suite = read_suite(file);
    found.judging = found.suite->judging;
    found.words =
        fmt::format("Judged by the suite {} and its baselines as they are now.", file.filename().generic_string());
  };
  found.judging.against_baseline = false;
  found.judging.against_median = true;
  if (!command.suite.empty()) {
    take(command.suite);
    return found;
  }
  try {
    if (!night.suite_file.empty()) take(night.suite_file);
  } catch (const InputError&) {
    found = {};
    found.judging.against_baseline = false;
    found.judging.against_median = true;
  }
  if (!found.suite) {
    found.words = "The suite of this night cannot be read any more: judged by the nights before, without baselines.";
  }
  return found;
}

/// The night's cases, as the suite describes them if it does.
class NightCases {
 public:
  NightCases(const std::vector<std::string>& names, const std::optional<Suite>& suite) {
    for (const std::string& name : names) {
      const Case* one = suite ? find(*suite, name) : nullptr;
      if (one == nullptr) {
        one = &alone_.emplace_back();
        alone_.back().id = name;
      }
      cases_.push_back(one);
    }
  }

  [[nodiscard]] const std::vector<const Case*>& list() const { return cases_; }

 private:
  static const Case* find(const Suite& suite, const std::string& name) {
    for (const Case& one : suite.cases) {
      if (one.id == name) return &one;
    }
    return nullptr;
  }

  std::list<Case> alone_;
  std::vector<const Case*> cases_;
};

NightReport judge_again(History& history, const Night& night, const Yardstick& by) {
  const std::vector<std::string> names = history.case_names(night.id);
  const NightCases cases(names, by.suite);
  const Baselines baselines = by.suite ? read_baselines(by.suite->baselines) : Baselines();
  NightReport report = judge_night(history, night, cases.list(), baselines, by.judging, night.started.substr(0, 10));
  // Of a choice of cases nothing is gone.
  if (by.suite && night.only.empty()) add_gone(*by.suite, baselines, report);
  report.is_finished = !night.finished.empty();
  report.code = code_of(report);
  return report;
}

}  // namespace

int write_night_report(const NightReportCommand& command, const Console& console) {
  return guarded(console, [&] {
    check_outputs({command.out}, {command.history, command.suite});
    History history(command.history, Access::read);
    const std::vector<Night> nights = history.nights();
    const Night& night = night_called(command.night, nights);
    const Yardstick by = yardstick_for(command, night);
    if (by.suite && by.suite->name != night.suite) {
      throw InputError({by.suite->file.string(), 0, 0}, fmt::format("is the suite '{}', but night {} is one of '{}'",
                                                                    by.suite->name, night.id, night.suite));
    }
    if (by.suite) check_outputs({command.out}, {by.suite->file, by.suite->baselines, log_of(by.suite->baselines)});
    const NightReport report = judge_again(history, night, by);
    NightPage page{report, night, by.judging, command.last, {by.words}};
    if (night.finished.empty()) {
      page.notes.emplace_back(
          "This night was stopped, is running, or was a part of a resumed one: cases may be missing.");
    }
    write_file(command.out, format_night_page(page, history));
    console.out << fmt::format("{}: night {}: {}", command.out.string(), night.id, format_headline(report));
  });
}

}  // namespace concord::compare::nightly
