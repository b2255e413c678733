#include "compare/program/nightly_options.h"

#include <string_view>

#include "compare/nightly/command.h"

namespace concord::compare::nightly {

namespace {

CLI::Option* add_slurm(CLI::App& app, NightlyCommand& command) {
  CLI::Option* slurm = app.add_flag(
      "--slurm{}", command.slurm_text,
      "Run the cases as tasks of a Slurm job array and merge their results in a second job, which ends with\n"
      "nightly's exit code. All that follows goes to sbatch, such as --partition=night --time=02:00:00;\n"
      "--slurm='WORDS' may stand before other options. Prints both jobs and ends; --jobs N: N tasks at once");
  app.add_flag("--wait", command.wait, "With --slurm: wait for the merge, print its table, end with its exit code")
      ->needs(slurm);
  const char* inside = "Inside the jobs of --slurm";
  app.add_option("--slurm-task", command.slurm_task, "Run the cases of this task of the array; FOLDER of the night")
      ->group(inside);
  app.add_option("--slurm-merge", command.slurm_merge,
                 "Read what the tasks left in FOLDER, and report; by hand where the merge job was lost")
      ->group(inside);
  return slurm;
}

void add_nightly(CommandLine& line, const std::vector<std::string>& slurm_words) {
  const auto [app, command] = line.add<NightlyCommand>(
      "nightly", "Run a suite of cases, each in its own process, and compare the results with the accepted ones",
      run_nightly);
  app.add_option("SUITE", command.suite, "Suite file (TOML; compare/nightly/README.md)")->required();
  app.add_option("--jobs", command.jobs, "Worker processes; default: one for each processor")
      ->check(whole_number_from(1, 1024));
  app.add_option("--minutes", command.minutes, "Begin no case after so many minutes")
      ->check([](const std::string& text) { return why_not_within(text, 1e-3, 1e5); });
  app.add_option("--only", command.only, "Cases of this name alone: a part of it, or a pattern with * and ?");
  app.add_option("--history", command.history, "SQLite file that remembers every night");
  app.add_flag("--resume", command.resume, "Go on with the last night of the history if it was stopped");
  app.add_option("--json", command.json, "File for all results as JSON");
  app.add_option("--junit", command.junit, "File for JUnit XML, a test case for each case");
  app.add_option("--markdown", command.markdown, "File for the table of changes as Markdown");
  app.add_option("--report", command.report, "File for the night as an HTML page, with its trends");
  app.add_option("--out", command.out, "Folder for table.txt, regressions.md, night.json, junit.xml and night.html");
  app.add_option("--notify", command.notify, "Command of the shell that gets the Markdown on its standard input");
  app.add_option("--commit", command.commit, "Commit to record; default: CONCORD_COMMIT, else the built one");
  const CLI::Option* slurm = add_slurm(app, command);
  app.callback([slurm, slurm_words, &command = command] {
    command.slurm = slurm->count() > 0;
    // A single word is taken for several that were quoted together.
    if (slurm_words.size() == 1) {
      command.slurm_text += ' ' + slurm_words.front();
    } else {
      command.slurm_words = slurm_words;
    }
  });
}

void add_accept(CommandLine& line) {
  const auto [app, command] =
      line.add<AcceptCommand>("accept", "Make results the baselines of a suite, with a reason", accept_baselines);
  app.add_option("SUITE|CASE", command.what, "Suite file, and names or patterns of its cases; default: all of them")
      ->required();
  app.add_option("--reason", command.reason, "Why; logged beside the baselines")->required();
  app.add_option("--history", command.history, "Accept the suite's last night in this file instead of running it");
  app.add_option("--from", command.from, "Accept a file that `nightly --json` wrote instead of running the cases");
  app.add_option("--jobs", command.jobs, "Worker processes; default: one for each processor")
      ->check(whole_number_from(1, 1024));
  app.add_option("--commit", command.commit, "Commit to record; default: CONCORD_COMMIT, else the built one");
}

void add_history(CommandLine& line) {
  const auto [app, command] =
      line.add<HistoryCommand>("history", "The trend of a case over the nights, with its steps", show_history);
  app.add_option("CASE", command.name, "Name of the case")->required();
  app.add_option("--history", command.history, "The file that remembers")->required();
  app.add_option("--suite", command.suite, "Name of the suite, where several have a case of this name");
  app.add_option("--component", command.component, "One component alone: its name or a part of it");
  app.add_option("--last", command.last, "So many nights; default: 30")->check(whole_number_from(1, 100000));
}

void add_diff(CommandLine& line) {
  const auto [app, command] =
      line.add<DiffCommand>("diff", "What changed between two files of results, nights or commits", show_difference);
  app.add_option("A", command.a,
                 "File of `nightly --json` or `compare --json`; with --history a night's number, last, last-1, or a\n"
                 "commit")
      ->required();
  app.add_option("B", command.b, "The same")->required();
  app.add_option("--history", command.history, "The file that remembers the nights");
  app.add_option("--suite", command.suite,
                 "Suite whose nights are meant and whose [judge] counts; default: any, and the defaults");
  app.add_option("--json", command.json, "File for the difference as JSON");
  app.add_option("--junit", command.junit, "File for JUnit XML");
  app.add_option("--markdown", command.markdown, "File for the table of changes as Markdown");
}

}  // namespace

std::vector<std::string> take_slurm_words(int& argc, char** argv) {
  if (argc < 2 || std::string_view(argv[1]) != "nightly") return {};
  for (int k = 2; k < argc; ++k) {
    if (std::string_view(argv[k]) != "--slurm") continue;
    std::vector<std::string> words(argv + k + 1, argv + argc);
    argc = k + 1;
    return words;
  }
  return {};
}

void add_nights(CommandLine& line, const std::vector<std::string>& slurm_words) {
  add_nightly(line, slurm_words);
  add_accept(line);
  add_history(line);
  add_diff(line);
}

}  // namespace concord::compare::nightly
