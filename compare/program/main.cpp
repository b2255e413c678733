#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>

#include "cartesian/solver.h"
#include "compare/analyses/command.h"
#include "compare/fuzz/command.h"
#include "compare/invariance/command.h"
#include "compare/invariance/moves.h"
#include "compare/joint_check/command.h"
#include "compare/nightly/command.h"
#include "compare/page/page.h"
#include "compare/program/command_line.h"
#include "compare/program/commands.h"
#include "compare/program/examples.h"
#include "compare/program/frame.h"
#include "compare/program/fuzz_options.h"
#include "compare/program/nightly_options.h"
#include "compare/program/run_options.h"
#include "compare/report/origin.h"
#ifdef CONCORD_HAS_SIMBODY
#include "compare/oracle/simbody_oracle.h"
#endif
#include "relative/solver.h"

/// The command line of `concord`, which binds both solvers.
namespace {

using namespace concord;

constexpr const char* kAbout =
    "concord: a multibody machine solved twice, by Cartesian and by relative coordinates;\n"
    "every joint reaction compared.";

constexpr const char* kEpilogue =
    R"(Exit codes: 0 agree, 1 differ, 2 bad input, 3 could not finish, 4 a baseline is missing or of another model.
Interrupted by SIGINT, SIGTERM or SIGHUP: 128 + the signal's number.
Units are SI and radians. Model files: data/README.md; how a verdict is reached: compare/README.md.)";

int compare_models(compare::CompareCommand& command, const compare::SolverMakers& makers,
                   const compare::Console& console) {
  if (!command.third_name.empty()) {
#ifdef CONCORD_HAS_SIMBODY
    command.make_third = compare::oracle::make_simbody;
#else
    console.err
        << "error: --oracle simbody: this program was built without Simbody; install the package libsimbody-dev, "
           "configure the build folder with cmake -DCONCORD_SIMBODY=ON and build; compare/run does so by itself\n";
    return compare::kBadInput;
#endif
  }
  return compare::compare_models(command, makers, console);
}

void add_axes(CLI::App& command, std::string& axes) {
  command.add_option("--axes", axes,
                     "world, or a body: its axes, in which tables and CSV files tell the wrenches of joints and force\n"
                     "elements, too; default: each in the frame of its own side. Nothing is judged in them");
}

/// The option, which no option that belongs to runs goes with.
void add_same_state(CLI::App& app, compare::VerifyOptions& options) {
  app.add_flag_function(
      "--same-state", [&options](std::int64_t) { options.integrates = false; },
      "Judge without integrating, in a fraction of a second: the start, a short step from it, and states drawn near\n"
      "these. The checks are rank, same state and audit; without options that belong to runs");
  app.callback([&app, &options] {
    if (options.integrates) return;
    for (const char* of_runs : {"--until", "--rtol", "--samples", "--cartesian-integrator", "--relative-integrator",
                                "--orders", "--out", "--report", "--reference"}) {
      if (app.count(of_runs) > 0) throw CLI::ExcludesError("--same-state", of_runs);
    }
  });
}

void add_compare(compare::CommandLine& line) {
  const auto [app, command] = line.add<compare::CompareCommand>(
      "compare", "Solve each model twice and judge every joint reaction", compare_models);
  app.add_option("MODEL", command.models, "Model files (TOML)")->required();
  compare::add_run_options(app, command.options);
  app.add_option("--cartesian-integrator", command.options.integrators[0],
                 "Integrator of the Cartesian solver; `concord info` lists them");
  app.add_option("--relative-integrator", command.options.integrators[1],
                 "Integrator of the relative solver; `concord info` lists them");
  app.add_option("--seed", command.options.seed,
                 "Seed of the random states that both solvers are asked about; default: 19971025")
      ->check(compare::why_no_whole_number);
  app.add_flag("--all", command.all_rows, "Print every component, too, with the scale that judges it");
  add_axes(app, command.axes);
  app.add_flag("--orders", command.options.orders,
               "Run at looser tolerances, too, and tell how each solver's errors fall with them; never judged");
  app.add_option("--out", command.out, "Folder for results: NetCDF and CSV of each solver, the table, plots (SVG)");
  app.add_option("--json", command.json, "File for the verdict as JSON");
  app.add_option("--junit", command.junit, "File for the verdict as JUnit XML, a test case for each judged row");
  app.add_option("--report", command.report,
                 "File for the verdict as an HTML page: table, curves and the machine in motion");
  app.add_option("--reference", command.reference,
                 "CSV file of values from another source: equal, in another convention, one of many, or wrong?");
  app.add_option("--oracle", command.third_name,
                 "Another program as a third opinion at the same state: simbody (compare/oracle/README)")
      ->check(CLI::IsMember({"simbody"}));
  add_same_state(app, command.options);
}

void add_run(compare::CommandLine& line) {
  const auto [app, command] = line.add<compare::RunCommand>(
      "run", "Integrate a model with one solver, or with each alone, and print the peak reactions", compare::run_model);
  app.add_option("MODEL", command.model, "Model file (TOML)")->required();
  app.add_option("--solver", command.solver, "Which solver; default: both, one after the other")
      ->check(CLI::IsMember({"cartesian", "relative"}));
  app.add_option("--integrator", command.integrator, "Which of this solver's integrators; `concord info` lists them");
  compare::add_run_options(app, command.options);
  add_axes(app, command.axes);
  app.add_option("--out", command.out, "Folder for results: NetCDF and CSV");
}

void add_info(compare::CommandLine& line) {
  const auto [app, model] = line.add<std::filesystem::path>(
      "info", "Bodies, joints, degrees of freedom, loops, cut joints, rank, uniqueness", compare::show_info);
  app.add_option("MODEL", model, "Model file (TOML)")->required();
}

using compare::analyses::Analysis;
using compare::analyses::AnalysisCommand;

/// With what all analyses have in common; the caller adds what is an analysis' own.
compare::CommandLine::Added<AnalysisCommand> add_analysis(compare::CommandLine& line, Analysis analysis,
                                                          const char* name, const char* about) {
  const auto added = line.add<AnalysisCommand>(name, about, compare::analyses::analyse_model);
  added.command.analysis = analysis;
  added.app.add_option("MODEL", added.command.model, "Model file (TOML)")->required();
  added.app.add_flag("--all", added.command.all_rows, "Print every component, not only the worst of each side");
  added.app.add_option("--json", added.command.json, "File for the results as JSON");
  added.app.add_option("--out", added.command.out, "Folder for results: NetCDF and CSV of each solver");
  return added;
}

void add_analyses(compare::CommandLine& line) {
  add_analysis(line, Analysis::statics, "statics", "Static equilibrium by both solvers");
  const auto linearize = add_analysis(line, Analysis::linearize, "linearize",
                                      "Eigenvalues and modes about the start or the equilibrium, by both solvers");
  linearize.app.add_option("--at", linearize.command.at, "State to linearize about; default: start")
      ->check(CLI::IsMember({"start", "equilibrium"}));
  const auto kinematics =
      add_analysis(line, Analysis::kinematics, "kinematics",
                   "Motion and reactions of a machine whose motion is fully driven, by both solvers");
  compare::add_run_options(kinematics.app, kinematics.command.options);
  const auto inverse =
      add_analysis(line, Analysis::inverse, "inverse",
                   "Total coordinate forces (springs and motors of the coordinate included) that give the kept\n"
                   "coordinates prescribed accelerations, by both solvers");
  inverse.app.add_option("--acceleration", inverse.command.accelerations,
                         "joint.coordinate=value [m/s2, rad/s2]; default of every kept coordinate: 0");
}

void add_joint(compare::CommandLine& line) {
  const auto [app, command] = line.add<compare::joint_check::JointCommand>(
      "joint", "Prove or refute joint types: what they forbid, permit and read, by both solvers, in all kinds of rigs",
      compare::joint_check::check_joints);
  app.add_option("NAME", command.names, "Joint types of the catalogue");
  app.add_flag("--all", command.all, "Every type of the catalogue");
  app.add_option("--seed", command.seed, "Seed of the poses; default: 19971025")->check(compare::why_no_whole_number);
  app.add_option("--poses", command.poses, "How many poses; default: 20")->check(compare::whole_number_from(1, 10000));
  app.add_option("--pose", command.pose, "Only this pose of the seed, counted from 0")
      ->check(compare::whole_number_from(0, 1000000));
  app.add_option("--out", command.out, "Folder for the sheets, as text and as JSON");
}

void add_invariance(compare::CommandLine& line) {
  const auto [app, command] = line.add<compare::invariance::InvarianceCommand>(
      "invariance", "Hold each solver against itself: the same machine described in equivalent ways",
      compare::invariance::try_invariance);
  app.add_option("MODEL", command.models, "Model files (TOML)")->required();
  app.add_option("--move", command.options.moves, "Only this move; may be given several times")
      ->allow_extra_args(false)
      ->check(CLI::IsMember(compare::invariance::move_names()));
  app.add_option("--seed", command.options.seed, "Seed of the moves and of the states; default: 19971025")
      ->check(compare::why_no_whole_number);
  app.add_option("--json", command.json, "File for the results as JSON");
}

/// A page of results: of a folder, or of a history, which everything else is.
struct ReportCommand {
  compare::nightly::NightReportCommand of_history;  // its history may be a folder
  std::string misplaced;                            // the first option that was given and belongs to a history alone
};

int write_report(const ReportCommand& command, const compare::Console& console) {
  const std::filesystem::path& what = command.of_history.history;
  if (!std::filesystem::is_directory(what)) return compare::nightly::write_night_report(command.of_history, console);
  if (command.misplaced.empty()) return compare::page::write_report({what, command.of_history.out}, console);
  console.err << fmt::format("{}: error: is a folder of results; {} belongs to a history\n", what.string(),
                             command.misplaced);
  return compare::kBadInput;
}

void add_report(compare::CommandLine& line) {
  const auto [app, command] =
      line.add<ReportCommand>("report", "Write a folder of results, or a night, as one HTML page", write_report);
  compare::nightly::NightReportCommand& night = command.of_history;
  app.add_option("FOLDER|HISTORY", night.history,
                 "Folder that `concord compare --out` wrote, or the SQLite file of `concord nightly --history`")
      ->required();
  app.add_option("-o,--output", night.out, "File for the page")->required();
  const char* of_history = "Of a history";
  app.add_option("--night", night.night, "Number of the night, last, last-1, or a commit; default: last")
      ->group(of_history);
  app.add_option("--suite", night.suite, "Suite by which it is judged; default: where it lay that night")
      ->group(of_history);
  app.add_option("--last", night.last, "So many nights in the trends; default: 100")
      ->check(compare::whole_number_from(1, 100000))
      ->group(of_history);
  app.callback([&app = app, &command = command] {
    for (const char* option : {"--last", "--suite", "--night"}) {
      if (app.count(option) > 0) command.misplaced = option;
    }
  });
}

/// Reads the command line and does what it says.
int run_program(int argc, char** argv) {
  CLI::App program(kAbout, "concord");
  program.footer(compare::first_examples() + '\n' + kEpilogue);
  program.set_version_flag("--version", compare::version_words());
  program.require_subcommand(1);
  const std::vector<std::string> slurm_words = compare::nightly::take_slurm_words(argc, argv);
  compare::CommandLine line(program);
  // In the order in which --help lists them.
  add_compare(line);
  add_run(line);
  add_info(line);
  add_analyses(line);
  add_joint(line);
  add_invariance(line);
  compare::fuzz::add_fuzz(line);
  compare::nightly::add_nights(line, slurm_words);
  add_report(line);
  compare::add_examples(program);
  try {
    compare::require_known_command(program, argc, argv);
    program.parse(argc, argv);
    compare::require_values(program);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? compare::kAgree : compare::kBadInput;
  }
  const compare::SolverMakers makers{cartesian::make_solver, relative::make_solver};
  return line.run(makers, {std::cout, std::cerr, compare::can_show_progress(), compare::can_show_colours()});
}

}  // namespace

int main(int argc, char** argv) {
  return compare::run_guarded([&] { return run_program(argc, argv); });
}
