#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <ostream>

#include "common/error.h"
#include "common/reading/spelling.h"
#include "common/reading/text_file.h"
#include "compare/nightly/baseline.h"
#include "compare/nightly/command.h"
#include "compare/nightly/history.h"
#include "compare/nightly/night.h"
#include "compare/nightly/regression.h"
#include "compare/nightly/suite.h"
#include "compare/nightly/tables.h"
#include "compare/nightly/trend.h"
#include "compare/report/console.h"
#include "compare/report/files.h"
#include "compare/report/text_table.h"

namespace concord::compare::nightly {

namespace {

namespace fs = std::filesystem;

/// What is asked to be accepted.
struct Asked {
  Suite suite;
  std::vector<const Case*> cases;
  bool is_whole = true;  // the whole suite
};

std::string summary_of(const Result& result) {
  const auto [same_state, same_run, refined] = worst_digits(result);
  return fmt::format("{}, digits {} / {} / {}, evaluations {} / {}, steps {} / {}", to_string(result.ending),
                     digits_cell(same_state), digits_cell(same_run), digits_cell(refined), result.cost[0].evaluations,
                     result.cost[1].evaluations, result.cost[0].steps, result.cost[1].steps);
}

/// Makes results baselines.
class Acceptance {
 public:
  Acceptance(const AcceptCommand& command, const SolverMakers& makers, const Console& console)
      : command_(command),
        makers_(makers),
        console_(console),
        today_(command.today.empty() ? utc_now().substr(0, 10) : command.today),
        scratch_(scratch_place()) {}

  int run() {
    if (command_.reason.find_first_not_of(" \t\n") == std::string::npos) {
      throw InputError({"--reason", 0, 0}, "say why these results are accepted");
    }
    if (!command_.history.empty() && !command_.from.empty()) {
      throw InputError({"--from", 0, 0}, "give --history or --from, not both");
    }
    asked_.suite = read_suite(suite_file());
    choose_cases();
    const WaitingLock lock(asked_.suite.file);  // who else accepts reads all baselines and writes them, too
    check_target(asked_.suite.baselines);
    check_target(log_of(asked_.suite.baselines));
    baselines_ = read_baselines(asked_.suite.baselines);
    take_results();
    if (asked_.is_whole) drop_gone();
    write();
    return refused_ == 0 ? kAgree : kDiffer;
  }

 private:
  /// The word that names a file; else the suite of the history's last night.
  fs::path suite_file() {
    for (const std::string& word : command_.what) {
      if (!fs::is_regular_file(word)) continue;
      suite_word_ = word;
      return word;
    }
    if (!command_.history.empty() && fs::exists(command_.history)) {
      const std::vector<Night> nights = History(command_.history, Access::read).nights();
      if (!nights.empty() && !nights.back().suite_file.empty()) return nights.back().suite_file;
    }
    if (command_.what.front().ends_with(".toml")) static_cast<void>(read_text_file(command_.what.front()));
    throw InputError({command_.what.front(), 0, 0},
                     "no suite is named: give the suite's file, or --history FILE, whose last night tells it");
  }

  void choose_cases() {
    for (const Case& one : asked_.suite.cases) asked_.cases.push_back(&one);
    std::vector<std::string> patterns;
    for (const std::string& word : command_.what) {
      if (word != suite_word_) patterns.push_back(word);
    }
    if (patterns.empty()) return;
    asked_.is_whole = false;
    for (const std::string& pattern : patterns) {
      const auto is_it = [&](const Case* one) { return one->id == pattern || is_meant(one->id, pattern); };
      if (std::none_of(asked_.cases.begin(), asked_.cases.end(), is_it)) {
        throw InputError({asked_.suite.file.string(), 0, 0}, fmt::format("no case is called '{}'", pattern));
      }
    }
    std::erase_if(asked_.cases, [&](const Case* one) {
      return std::none_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
        // The whole name of a case means it alone.
        const bool is_name = std::any_of(asked_.suite.cases.begin(), asked_.suite.cases.end(),
                                         [&](const Case& other) { return other.id == pattern; });
        return is_name ? one->id == pattern : is_meant(one->id, pattern);
      });
    });
  }

  void take_results() {
    if (!command_.from.empty()) {
      NightFile file = read_night_json(command_.from);
      if (file.title != asked_.suite.name) {
        throw InputError({command_.from.string(), 0, 0},
                         fmt::format("holds results of '{}', not of '{}'", file.title, asked_.suite.name));
      }
      std::map<std::string, Result> found;
      for (Result& one : file.results) found.emplace(one.id, std::move(one));
      for (const Case* one : asked_.cases) take(*one, found.contains(one->id) ? &found.at(one->id) : nullptr);
      return;
    }
    const bool is_new = command_.history.empty();
    History history(is_new ? scratch_.path() / "night.sqlite" : command_.history,
                    is_new ? Access::write : Access::read);
    long night = 0;
    if (is_new) {
      night = history.begin(asked_.suite.name, "", origin_of_program(command_.commit), utc_now());
      const auto store = [&](const Result& result) { history.store(night, result); };
      run_cases(asked_.cases, {command_.jobs, {}}, store, {}, makers_, console_);
    } else {
      const std::vector<Night> nights = history.nights(asked_.suite.name);
      if (nights.empty()) {
        throw InputError({command_.history.string(), 0, 0}, fmt::format("holds no night of '{}'", asked_.suite.name));
      }
      night = nights.back().id;
    }
    for (const Case* one : asked_.cases) {
      const auto result = history.find(night, one->id);
      take(*one, result ? &*result : nullptr);
    }
  }

  void refuse(const Case& one, const std::string& reason) {
    ++refused_;
    console_.err << fmt::format("{} is not accepted: {}\n", one.id, reason);
  }

  void take(const Case& one, const Result* result) {
    if (result == nullptr) return refuse(one, "there is no result of it");
    if (result->ending == Ending::not_run) return refuse(one, "it was not run");
    if (!result->definition.empty() && result->definition != definition_of(one)) {
      return refuse(one, "it was run before its model or what the suite says of it was changed: run it again");
    }
    if (!result->is_green() && !counts_as_known_red(one, *result, today_)) {
      return refuse(one, fmt::format("it is red ({}){}", to_string(result->ending),
                                     one.known_red ? fmt::format(", and its known_red does not excuse that: it is for "
                                                                 "what a solver answers, until {}",
                                                                 one.known_red->until)
                                                   : "; a case that must be lived with gets known_red in the suite"));
    }
    const Result accepted = as_baseline(*result);
    const auto old = baselines_.find(one.id);
    if (old == baselines_.end()) {
      log_ += fmt::format("  {}: new: {}\n", one.id, summary_of(accepted));
    } else if (format_baselines({{one.id, accepted}}) != format_baselines({{one.id, old->second}})) {
      log_ += fmt::format("  {}: old: {}\n  {}  new: {}\n", one.id, summary_of(old->second),
                          std::string(one.id.size(), ' '), summary_of(accepted));
      log_changes(old->second, accepted);
    }
    baselines_.insert_or_assign(one.id, accepted);
    ++accepted_;
  }

  void log_changes(const Result& old, const Result& accepted) {
    for (const Change& change : changes_between(old, accepted, asked_.suite.judging, "")) {
      log_ += fmt::format("    {}\n", change_words(change));
    }
  }

  void drop_gone() {
    for (auto entry = baselines_.begin(); entry != baselines_.end();) {
      const auto is_it = [&](const Case& one) { return one.id == entry->first; };
      if (std::any_of(asked_.suite.cases.begin(), asked_.suite.cases.end(), is_it)) {
        ++entry;
        continue;
      }
      log_ += fmt::format("  {}: gone: {}\n", entry->first, summary_of(entry->second));
      entry = baselines_.erase(entry);
    }
  }

  void write() {
    if (!log_.empty()) {
      write_file(asked_.suite.baselines, format_baselines(baselines_));
      write_down(asked_.suite.baselines, origin_of_program(command_.commit), command_.reason, log_);
    }
    console_.out << log_
                 << fmt::format("{}: {} accepted, {} not{}\n", asked_.suite.baselines.generic_string(), accepted_,
                                refused_, log_.empty() ? "; nothing changed" : "");
  }

  const AcceptCommand& command_;
  const SolverMakers& makers_;
  const Console& console_;
  std::string today_;
  StagedFolder scratch_;
  Asked asked_;
  std::string suite_word_;
  Baselines baselines_;
  std::string log_;
  int accepted_ = 0;
  int refused_ = 0;
};

}  // namespace

int accept_baselines(const AcceptCommand& command, const SolverMakers& makers, const Console& console) {
  return guarded(console, [&] { return Acceptance(command, makers, console).run(); });
}

int show_history(const HistoryCommand& command, const Console& console) {
  return guarded(console, [&] {
    History history(command.history, Access::read);
    const std::vector<std::string> suites = history.suites_of_case(command.name);
    if (suites.empty()) {
      throw InputError(
          {command.history.string(), 0, 0},
          fmt::format("no case '{}': {}", command.name, suggestion(command.name, history.case_names(), "cases")));
    }
    const std::string& suite = command.suite.empty() ? suites.front() : command.suite;
    const std::vector<Entry> nights = history.of_case(suite, command.name, command.last);
    if (nights.empty()) {
      throw InputError({command.history.string(), 0, 0},
                       fmt::format("no case '{}' in a night of the suite '{}': it is in those of {}", command.name,
                                   suite, fmt::join(suites, ", ")));
    }
    console.out << format_trend(command.name, nights, command.component, {});
    if (suites.size() > 1 && command.suite.empty()) {
      console.out << fmt::format("note: nights of the suite '{}'; a case of this name is in those of {} too: --suite\n",
                                 suite, fmt::join(suites.begin() + 1, suites.end(), ", "));
    }
  });
}

}  // namespace concord::compare::nightly
