#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/nightly/regression.h"

/// A night, or the difference of two, as text, Markdown, JSON and JUnit XML.
namespace concord::compare::nightly {

/// One case in the tables.
struct CaseLine {
  std::string id;
  std::string work;
  Ending ending = Ending::not_run;
  int judged = 0;
  int total = 0;
  std::array<std::optional<double>, 3> worst;  // digits of same state, same run, refined
  std::array<long, 2> evaluations{};
  std::array<long, 2> steps{};
  int code = 0;          // of the program, for this case alone
  bool has_past = true;  // else there was nothing to compare it with
  std::vector<Change> changes;
  std::string note = {};  // what is said of a green one
};

CaseLine case_line_of(const Result& result, std::vector<Change> changes);

/// All that is reported of a night, or of a difference.
struct NightReport {
  std::string title;  // "smoke"
  std::string kind;   // "concord night", "concord difference"
  Origin origin;
  std::string started;
  std::vector<CaseLine> cases;
  std::vector<Change> others;  // of cases that are gone
  int code = 0;
  bool is_finished = true;   // else cases may be missing
  std::string trouble = {};  // why the history lacks cases of this night, or of one that is compared; else empty
  std::string only = {};     // the pattern of the cases that were asked for; empty: all of the suite
};

/// The report's code, from its cases and other changes.
int code_of(const NightReport& report);

/// One sentence: "green smoke: 20 cases agree" or "red smoke: 20 cases: 18 agree, 1 differs, 1 crashed; 2 worse".
std::string format_headline(const NightReport& report);

/// The same in whole words: "The night of smoke is red: of 20 cases 18 agree, 1 differs, 1 crashed; 2 worse."
std::string format_sentence(const NightReport& report);

/// All changes, the gravest first.
std::vector<const Change*> all_changes(const NightReport& report);
nlohmann::ordered_json change_json(const Change& change);
/// "joint D on slider, F_x, same run: 9.1 -> 7.0 and 2 more".
std::string change_words(const Change& change);

/// "812 / 1011", Cartesian and relative, in one cell; "-" of what integrates nothing.
std::string pair_cell(const std::array<long, 2>& pair);

/// The gravest kind of change of a case in one cell: "worse"; "as accepted" if there is none.
std::string past_words(const CaseLine& line);

/// The table of cases, the table of changes and the headline. Says nothing that changes from run to run.
std::string format_report(const NightReport& report);

/// The headline, where the results come from, and the table of changes, as Markdown.
std::string format_markdown(const NightReport& report);

/// JUnit XML: a test case for each case; a red one with all its changes, known red ones skipped.
std::string format_night_junit(const NightReport& report);

inline constexpr int kNightFormat = 1;

/// Writes the report and all results, one at a time, as JSON. `next` gives them in their order.
void write_night_json(const std::filesystem::path& file, const NightReport& report,
                      const std::function<std::optional<Result>()>& next);

/// What a JSON error says, without the library's own name for it.
std::string without_tag(const std::string& words);

/// Results of a file that write_night_json() wrote: those of the cases that the night came to.
struct NightFile {
  Origin origin;
  std::string title;
  std::vector<Result> results;
  std::string only = {};  // as in the report
  bool is_finished = true;
};
/// Throws InputError if it is no such file; a version that is not known is refused by name.
NightFile read_night_json(const std::filesystem::path& file);

}  // namespace concord::compare::nightly
