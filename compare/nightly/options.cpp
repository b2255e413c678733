#include "compare/nightly/options.h"

#include <CLI/CLI.hpp>

#include "compare/report/option_limits.h"
#include "compare/report/whole_number.h"

namespace concord::compare::nightly {

NightlyCommands::NightlyCommands(CLI::App& program) {
  add_nightly(program);
  add_accept(program);
  add_history(program);
  add_diff(program);
}

void NightlyCommands::add_nightly(CLI::App& program) {
  CLI::App* app = program.add_subcommand(
      "nightly", "Run a suite of cases, each in its own process, and compare the results with the accepted ones");
  nightly_app_ = app;
  app->add_option("SUITE", nightly_.suite, "Suite file (TOML; compare/nightly/README.md)")->required();
  app->add_option("--jobs", nightly_.jobs, "Worker processes; default: one for each processor")
      ->check(whole_number_from(1, 1024));
  app->add_option("--minutes", nightly_.minutes, "Begin no case after so many minutes")
      ->check([](const std::string& text) { return why_not_within(text, 1e-3, 1e5); });
  app->add_option("--only", nightly_.only, "Cases of this name alone: a part of it, or a pattern with * and ?");
  app->add_option("--history", nightly_.history, "SQLite file that remembers every night");
  app->add_flag("--resume", nightly_.resume, "Go on with the last night of the history if it was stopped");
  app->add_option("--json", nightly_.json, "File for all results as JSON");
  app->add_option("--junit", nightly_.junit, "File for JUnit XML, a test case for each case");
  app->add_option("--markdown", nightly_.markdown, "File for the table of changes as Markdown");
  app->add_option("--report", nightly_.report, "File for the night as an HTML page, with its trends");
  app->add_option("--out", nightly_.out, "Folder for table.txt, regressions.md, night.json, junit.xml and night.html");
  app->add_option("--notify", nightly_.notify, "Command of the shell that gets the Markdown on its standard input");
  app->add_option("--commit", nightly_.commit, "Commit to record; default: CONCORD_COMMIT, else the built one");
  add_slurm(*app);
}

void NightlyCommands::add_slurm(CLI::App& app) {
  CLI::Option* slurm = app.add_flag(
      "--slurm{}", nightly_.slurm_text,
      "Run the cases as tasks of a Slurm job array and merge their results in a second job, which ends with\n"
      "nightly's exit code. All that follows goes to sbatch, such as --partition=night --time=02:00:00;\n"
      "--slurm='WORDS' may stand before other options. Prints both jobs and ends; --jobs N: N tasks at once");
  app.add_flag("--wait", nightly_.wait, "With --slurm: wait for the merge, print its table, end with its exit code")
      ->needs(slurm);
  const char* inside = "Inside the jobs of --slurm";
  app.add_option("--slurm-task", nightly_.slurm_task, "Run the cases of this task of the array; FOLDER of the night")
      ->group(inside);
  app.add_option("--slurm-merge", nightly_.slurm_merge,
                 "Read what the tasks left in FOLDER, and report; by hand where the merge job was lost")
      ->group(inside);
  slurm_option_ = slurm;
}

int NightlyCommands::take_slurm_words(int argc, char** argv) {
  if (argc < 2 || std::string_view(argv[1]) != "nightly") return argc;
  for (int k = 2; k < argc; ++k) {
    if (std::string_view(argv[k]) != "--slurm") continue;
    nightly_.slurm_words.assign(argv + k + 1, argv + argc);
    return k + 1;
  }
  return argc;
}

void NightlyCommands::add_accept(CLI::App& program) {
  CLI::App* app = program.add_subcommand("accept", "Make results the baselines of a suite, with a reason");
  accept_app_ = app;
  app->add_option("SUITE|CASE", accept_.what, "Suite file, and names or patterns of its cases; default: all of them")
      ->required();
  app->add_option("--reason", accept_.reason, "Why; logged beside the baselines")->required();
  app->add_option("--history", accept_.history, "Accept the suite's last night in this file instead of running it");
  app->add_option("--from", accept_.from, "Accept a file that `nightly --json` wrote instead of running the cases");
  app->add_option("--jobs", accept_.jobs, "Worker processes; default: one for each processor")
      ->check(whole_number_from(1, 1024));
  app->add_option("--commit", accept_.commit, "Commit to record; default: CONCORD_COMMIT, else the built one");
}

void NightlyCommands::add_history(CLI::App& program) {
  CLI::App* app = program.add_subcommand("history", "The trend of a case over the nights, with its steps");
  history_app_ = app;
  app->add_option("CASE", history_.name, "Name of the case")->required();
  app->add_option("--history", history_.history, "The file that remembers")->required();
  app->add_option("--suite", history_.suite, "Name of the suite, where several have a case of this name");
  app->add_option("--component", history_.component, "One component alone: its name or a part of it");
  app->add_option("--last", history_.last, "So many nights; default: 30")->check(whole_number_from(1, 100000));
}

void NightlyCommands::add_diff(CLI::App& program) {
  CLI::App* app = program.add_subcommand("diff", "What changed between two files of results, nights or commits");
  diff_app_ = app;
  app->add_option("A", diff_.a,
                  "File of `nightly --json` or `compare --json`; with --history a night's number, last, last-1, or a\n"
                  "commit")
      ->required();
  app->add_option("B", diff_.b, "The same")->required();
  app->add_option("--history", diff_.history, "The file that remembers the nights");
  app->add_option("--suite", diff_.suite,
                  "Suite whose nights are meant and whose [judge] counts; default: any, and the defaults");
  app->add_option("--json", diff_.json, "File for the difference as JSON");
  app->add_option("--junit", diff_.junit, "File for JUnit XML");
  app->add_option("--markdown", diff_.markdown, "File for the table of changes as Markdown");
}

std::optional<int> NightlyCommands::run(const SolverMakers& makers, const Console& console) const {
  if (nightly_app_->parsed()) {
    NightlyCommand night = nightly_;
    night.slurm = slurm_option_->count() > 0;
    // A single word is taken for several that were quoted together.
    if (night.slurm_words.size() == 1) {
      night.slurm_text += ' ' + night.slurm_words.front();
      night.slurm_words.clear();
    }
    return run_nightly(night, makers, console);
  }
  if (accept_app_->parsed()) return accept_baselines(accept_, makers, console);
  if (history_app_->parsed()) return show_history(history_, console);
  if (diff_app_->parsed()) return show_difference(diff_, console);
  return std::nullopt;
}

}  // namespace concord::compare::nightly
