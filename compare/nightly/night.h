#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compare/nightly/result.h"
#include "compare/nightly/suite.h"
#include "compare/report/console.h"
#include "compare/states/branch.h"
#include "compare/verdict/verify.h"

/// Runs the cases of a suite, each in a worker process, and stores what each finds as soon as it ends.
namespace concord::compare::nightly {

struct NightOptions {
  int jobs = 0;                   // worker processes; 0: one for each processor
  std::optional<double> minutes;  // no case is begun after so long
  /// A folder for the pages of comparisons that do not agree, named as page_name_of() says; empty: none are written.
  std::filesystem::path pages = {};
};

/// "case_car_0a1b2c3d4e5f6071.html", a name for a file and a link: other characters than letters, digits and ".-_" give
/// way, and the number tells apart what would then be called alike.
std::string page_name_of(const std::string& id);

/// "2026-11-22 23:14:05", UTC; the day is what stands before the space.
std::string utc_now();

/// Keeps the result of a case.
using StoreResult = std::function<void(const Result&)>;

inline constexpr const char* kTimeIsUp = "the time of the night was up";

/// The result of a case that was not run, and why it was not.
Result not_run(const Case& one, const std::string& why);

/// By the wall time that they took, by name. New cases, of which nothing is known, come first. Then no processor waits
/// long for another one at the end.
void put_longest_first(const std::map<std::string, double>& wall_times, std::vector<const Case*>& cases);

/// Runs `cases`; progress goes to `console.err`: on a terminal one line that changes, else a line for each red case and
/// one every few seconds. What a case was asked stands in its result. Cases that were not begun in time are stored as
/// not run. Those that took longest (`wall_times`, by name) begin first, unless the time is limited. Returns whether
/// all were run.
bool run_cases(std::vector<const Case*> cases, const NightOptions& options, const StoreResult& store,
               const std::map<std::string, double>& wall_times, const SolverMakers& makers, const Console& console);

}  // namespace concord::compare::nightly
