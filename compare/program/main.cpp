#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>

#include "cartesian/solver.h"
#include "compare/fuzz/options.h"
#include "compare/invariance/command.h"
#include "compare/invariance/moves.h"
#include "compare/joint_check/command.h"
#include "compare/nightly/options.h"
#include "compare/page/command.h"
#include "compare/program/analysis_options.h"
#include "compare/program/commands.h"
#include "compare/program/examples.h"
#include "compare/program/frame.h"
#include "compare/program/run_options.h"
#include "compare/report/option_limits.h"
#include "compare/report/origin.h"
#include "compare/report/whole_number.h"
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

struct CommandLine {
  compare::CompareCommand compare;
  compare::RunCommand run;
  std::string solver;
  std::string integrator;
  std::filesystem::path info_model;
  std::string oracle;
  compare::joint_check::JointCommand joint;
  compare::invariance::InvarianceCommand invariance;
  compare::fuzz::FuzzCommand fuzz;
  std::filesystem::path report_of;  // a folder of results, or a history
  compare::nightly::NightReportCommand night_report;
};

CLI::App* add_compare(CLI::App& program, CommandLine& line) {
  CLI::App* command = program.add_subcommand("compare", "Solve each model twice and judge every joint reaction");
  command->add_option("MODEL", line.compare.models, "Model files (TOML)")->required();
  compare::add_run_options(*command, line.compare.options);
  command->add_option("--cartesian-integrator", line.compare.options.integrators[0],
                      "Integrator of the Cartesian solver; `concord info` lists them");
  command->add_option("--relative-integrator", line.compare.options.integrators[1],
                      "Integrator of the relative solver; `concord info` lists them");
  command
      ->add_option("--seed", line.compare.options.seed,
                   "Seed of the random states that both solvers are asked about; default: 19971025")
      ->check(compare::why_no_whole_number);
  command->add_flag("--all", line.compare.all_rows, "Print every component, not only the worst of each joint and side");
  command->add_flag("--orders", line.compare.options.orders,
                    "Run at looser tolerances, too, and tell how each solver's errors fall with them; never judged");
  command->add_option("--out", line.compare.out,
                      "Folder for results: NetCDF and CSV of each solver, the table, plots (SVG)");
  command->add_option("--json", line.compare.json, "File for the verdict as JSON");
  command->add_option("--junit", line.compare.junit,
                      "File for the verdict as JUnit XML, a test case for each judged row");
  command->add_option("--report", line.compare.report,
                      "File for the verdict as an HTML page: table, curves and the machine in motion");
  command->add_option("--reference", line.compare.reference,
                      "CSV file of reference values from another source, with their stated error (compare/README)");
  command
      ->add_option("--oracle", line.oracle,
                   "Another program as a third opinion at the same state: simbody (compare/oracle/README)")
      ->check(CLI::IsMember({"simbody"}));
  return command;
}

CLI::App* add_run(CLI::App& program, CommandLine& line) {
  CLI::App* command = program.add_subcommand("run", "Integrate a model with one solver and print the peak reactions");
  command->add_option("MODEL", line.run.model, "Model file (TOML)")->required();
  command->add_option("--solver", line.solver, "Which solver")
      ->required()
      ->check(CLI::IsMember({"cartesian", "relative"}));
  command->add_option("--integrator", line.integrator, "Which of the solver's integrators; `concord info` lists them");
  compare::add_run_options(*command, line.run.options);
  command->add_option("--out", line.run.out, "Folder for results: NetCDF and CSV");
  return command;
}

CLI::App* add_info(CLI::App& program, CommandLine& line) {
  CLI::App* command =
      program.add_subcommand("info", "Bodies, joints, degrees of freedom, loops, cut joints, rank, uniqueness");
  command->add_option("MODEL", line.info_model, "Model file (TOML)")->required();
  return command;
}

CLI::App* add_joint(CLI::App& program, CommandLine& line) {
  CLI::App* command = program.add_subcommand(
      "joint", "Prove or refute joint types: what they forbid, permit and read, by both solvers, in all kinds of rigs");
  command->add_option("NAME", line.joint.names, "Joint types of the catalogue");
  command->add_flag("--all", line.joint.all, "Every type of the catalogue");
  command->add_option("--seed", line.joint.seed, "Seed of the poses; default: 19971025")
      ->check(compare::why_no_whole_number);
  command->add_option("--poses", line.joint.poses, "How many poses; default: 20")
      ->check(compare::whole_number_from(1, 10000));
  command->add_option("--pose", line.joint.pose, "Only this pose of the seed, counted from 0")
      ->check(compare::whole_number_from(0, 1000000));
  command->add_option("--out", line.joint.out, "Folder for the sheets, as text and as JSON");
  return command;
}

CLI::App* add_invariance(CLI::App& program, CommandLine& line) {
  CLI::App* command = program.add_subcommand(
      "invariance", "Hold each solver against itself: the same machine described in equivalent ways");
  command->add_option("MODEL", line.invariance.models, "Model files (TOML)")->required();
  command->add_option("--move", line.invariance.options.moves, "Only this move; may be given several times")
      ->allow_extra_args(false)
      ->check(CLI::IsMember(compare::invariance::move_names()));
  command->add_option("--seed", line.invariance.options.seed, "Seed of the moves and of the states; default: 19971025")
      ->check(compare::why_no_whole_number);
  command->add_option("--json", line.invariance.json, "File for the results as JSON");
  return command;
}

CLI::App* add_report(CLI::App& program, CommandLine& line) {
  CLI::App* command = program.add_subcommand("report", "Write a folder of results, or a night, as one HTML page");
  command
      ->add_option("FOLDER|HISTORY", line.report_of,
                   "Folder that `concord compare --out` wrote, or the SQLite file of `concord nightly --history`")
      ->required();
  command->add_option("-o,--output", line.night_report.out, "File for the page")->required();
  const char* of_history = "Of a history";
  command
      ->add_option("--night", line.night_report.night, "Number of the night, last, last-1, or a commit; default: last")
      ->group(of_history);
  command
      ->add_option("--suite", line.night_report.suite, "Suite by which it is judged; default: where it lay that night")
      ->group(of_history);
  command->add_option("--last", line.night_report.last, "So many nights in the trends; default: 100")
      ->check(compare::whole_number_from(1, 100000))
      ->group(of_history);
  return command;
}

/// A folder is one of results, everything else a history.
int write_report(const CLI::App& app, CommandLine& line, const compare::Console& console) {
  if (!std::filesystem::is_directory(line.report_of)) {
    line.night_report.history = line.report_of;
    return compare::nightly::write_night_report(line.night_report, console);
  }
  for (const char* option : {"--night", "--suite", "--last"}) {
    if (app.count(option) == 0) continue;
    console.err << fmt::format("{}: error: is a folder of results; {} belongs to a history\n", line.report_of.string(),
                               option);
    return compare::kBadInput;
  }
  return compare::page::write_report({line.report_of, line.night_report.out}, console);
}

/// Puts the third opinion into the command; false if the program was built without it.
bool find_oracle(CommandLine& line) {
  line.compare.third_name = line.oracle;
#ifdef CONCORD_HAS_SIMBODY
  line.compare.make_third = compare::oracle::make_simbody;
  return true;
#else
  std::cerr << "error: --oracle simbody: this program was built without Simbody; install the package libsimbody-dev, "
               "configure the build folder with cmake -DCONCORD_SIMBODY=ON and build; compare/run does so by itself\n";
  return false;
#endif
}

/// All commands of the program, in the order in which --help lists them.
class Commands {
 public:
  Commands(CLI::App& program, CommandLine& line)
      : line_(line),
        compare_(add_compare(program, line)),
        run_(add_run(program, line)),
        info_(add_info(program, line)),
        analyses_(program),
        joint_(add_joint(program, line)),
        invariance_(add_invariance(program, line)),
        fuzz_(compare::fuzz::add_fuzz(program, line.fuzz)),
        nights_(program),
        report_(add_report(program, line)) {}

  /// Takes words that are not the program's own from the end of the line; returns how many are left.
  int take_slurm_words(int argc, char** argv) { return nights_.take_slurm_words(argc, argv); }

  /// Does what was asked for and returns the exit code.
  int run(const compare::SolverMakers& makers, const compare::Console& console) {
    if (compare_->parsed()) {
      if (!line_.oracle.empty() && !find_oracle(line_)) return compare::kBadInput;
      return compare::compare_models(line_.compare, makers, console);
    }
    if (run_->parsed()) {
      line_.run.is_cartesian = line_.solver == "cartesian";
      line_.run.options.integrators[line_.run.is_cartesian ? 0 : 1] = line_.integrator;
      return compare::run_model(line_.run, makers, console);
    }
    if (info_->parsed()) return compare::show_info(line_.info_model, makers, console);
    if (const auto* analysis = analyses_.parsed()) return compare::analyses::analyse_model(*analysis, makers, console);
    if (joint_->parsed()) return compare::joint_check::check_joints(line_.joint, console);
    if (invariance_->parsed()) return compare::invariance::try_invariance(line_.invariance, makers, console);
    if (fuzz_->parsed()) return compare::fuzz::fuzz_machines(line_.fuzz, makers, console);
    if (report_->parsed()) return write_report(*report_, line_, console);
    return nights_.run(makers, console).value_or(compare::kBadInput);
  }

 private:
  CommandLine& line_;
  const CLI::App* compare_;
  const CLI::App* run_;
  const CLI::App* info_;
  compare::AnalysisCommands analyses_;
  const CLI::App* joint_;
  const CLI::App* invariance_;
  const CLI::App* fuzz_;
  compare::nightly::NightlyCommands nights_;
  const CLI::App* report_;
};

/// Reads the command line and does what it says.
int run_program(int argc, char** argv) {
  CLI::App program(kAbout, "concord");
  program.footer(compare::first_examples() + '\n' + kEpilogue);
  program.set_version_flag("--version", compare::version_words());
  program.require_subcommand(1);
  CommandLine line;
  Commands commands(program, line);
  compare::add_examples(program);
  try {
    compare::require_known_command(program, argc, argv);
    program.parse(commands.take_slurm_words(argc, argv), argv);
    compare::require_values(program);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? compare::kAgree : compare::kBadInput;
  }
  const compare::SolverMakers makers{cartesian::make_solver, relative::make_solver};
  return commands.run(makers, {std::cout, std::cerr, compare::can_show_progress()});
}

}  // namespace

int main(int argc, char** argv) {
  return compare::run_guarded([&] { return run_program(argc, argv); });
}
