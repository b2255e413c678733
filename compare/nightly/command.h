#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compare/report/console.h"
#include "compare/states/branch.h"
#include "compare/verdict/verify.h"

/// `concord nightly`, `accept`, `history`, `report` of a history, and `diff`.
namespace concord::compare::nightly {

struct NightlyCommand {
  std::filesystem::path suite;
  int jobs = 0;                        // worker processes; 0: one for each processor
  std::optional<double> minutes = {};  // no case is begun after so long
  std::string only = {};               // pattern of the cases that are meant; empty: all
  std::filesystem::path history = {};  // empty: nothing is remembered
  bool resume = false;                 // goes on with the suite's last night if that was stopped
  std::filesystem::path json = {};
  std::filesystem::path junit = {};
  std::filesystem::path markdown = {};
  std::filesystem::path report = {};  // HTML page
  std::filesystem::path out = {};     // folder for all of these and the table
  std::string notify = {};            // command of the shell that gets the report on its standard input
  std::string commit = {};            // instead of the one that was built
  std::string today = {};             // "2026-11-22"; empty: what the clock says

  bool slurm = false;                         // the cases are run as jobs of a cluster
  std::string slurm_text = {};                // options for sbatch, to be split as a shell does
  std::vector<std::string> slurm_words = {};  // more of them
  bool wait = false;                          // until the jobs have ended
  std::filesystem::path slurm_task = {};      // folder of the night whose task this is
  std::filesystem::path slurm_merge = {};     // folder of the night that is merged
};

/// Runs a suite and holds it against its baselines. Returns 0 if nothing is red or worse, 1 if a case differs or became
/// worse, 2 for bad input, 3 if a case has no verdict or was lost or not run, 4 if all that is wrong is that baselines
/// are missing or of other models; with several the worst: 3, 2, 1, 4. With `slurm` 0 if the jobs were submitted, with
/// `wait` what the merge returns.
int run_nightly(const NightlyCommand& command, const SolverMakers& makers, const Console& console);

struct AcceptCommand {
  std::vector<std::string> what;       // a suite file and names or patterns of its cases
  std::string reason;                  // must not be empty
  std::filesystem::path history = {};  // whose last night is accepted
  std::filesystem::path from = {};     // or this file of results; without both the cases are run
  int jobs = 0;
  std::string commit = {};
  std::string today = {};  // "2026-11-22"; empty: what the clock says
};

/// Makes results the baselines of a suite, and logs who did it, when and why, with old and new numbers, beside them.
/// Cases that are gone from the suite lose their baseline if the whole suite is accepted. Returns 0 if all that were
/// asked for were accepted, 1 if one is red, which is not accepted unless it counts as known red today.
int accept_baselines(const AcceptCommand& command, const SolverMakers& makers, const Console& console);

struct HistoryCommand {
  std::string name;  // of the case
  std::string component = {};
  std::filesystem::path history;
  std::string suite = {};  // its name; empty: that of the latest night with this case
  int last = 30;           // nights
};

/// Prints the trend of a case.
int show_history(const HistoryCommand& command, const Console& console);

/// `concord report` of a history.
struct NightReportCommand {
  std::filesystem::path history;
  std::filesystem::path out;         // the page
  std::string night = "last";        // number, "last", "last-1", or a commit
  std::filesystem::path suite = {};  // by which the night is judged; empty: where it lay that night
  int last = 100;                    // nights that the trends show
};

/// Writes the page of a night. It is judged anew by the suite and its baselines as they are now, or, where the suite is
/// not there any more, by the nights before. Returns 0 if the page was written.
int write_night_report(const NightReportCommand& command, const Console& console);

struct DiffCommand {
  std::string a;  // a file of `nightly --json` or `compare --json`; with a history: the number of a night, "last",
                  // "last-1", or a commit
  std::string b;
  std::filesystem::path history = {};
  std::filesystem::path suite = {};  // whose nights and [judge] count; empty: any, the defaults
  std::filesystem::path json = {};
  std::filesystem::path junit = {};
  std::filesystem::path markdown = {};
};

/// Prints what changed from A to B. Returns 0 if nothing is worse, 1 if something is, 4 if only cases differ whose
/// model or settings are others.
int show_difference(const DiffCommand& command, const Console& console);

}  // namespace concord::compare::nightly
