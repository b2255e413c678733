#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <iostream>

#include "cartesian/solver.h"
#include "common/reading/magnitude.h"
#include "common/reading/spelling.h"
#include "compare/analyses/command.h"
#include "compare/fuzz/options.h"
#include "compare/invariance/command.h"
#include "compare/invariance/moves.h"
#include "compare/joint_check/command.h"
#include "compare/nightly/options.h"
#include "compare/nightly/origin.h"
#include "compare/page/command.h"
#include "compare/program/commands.h"
#include "compare/report/interrupt.h"
#ifdef CONCORD_HAS_SIMBODY
#include "compare/oracle/simbody_oracle.h"
#endif
#include "relative/solver.h"

/// The command line: the only place that knows both solvers.
namespace {

using namespace concord;

constexpr const char* kAbout =
    "concord: a multibody machine solved twice, by Cartesian and by relative coordinates;\n"
    "every joint reaction compared.";

constexpr const char* kEpilogue = R"(Examples:
  concord compare data/models/slider_crank_flexible.toml
      judge every joint reaction; one row for each joint and side
  concord compare data/models/*.toml --json verdict.json
      all models, a summary at the end, the verdicts for other programs
  concord compare my.toml --until 0.5 --rtol 1e-10 --all --out results
      all components; NetCDF, CSV, plots and the table in results/
  concord compare my.toml --report my.html
      a page with table, curves and the machine in motion
  concord run my.toml --solver relative --out results
      one solver alone
  concord info my.toml
      bodies, joints, loops, rank, and which reactions are unique
  concord statics my.toml --json equilibrium.json
      the static equilibrium by both solvers
  concord linearize my.toml --at equilibrium
      frequencies, damping ratios and mode shapes
  concord kinematics my.toml
      motion and reactions of a machine whose motion is fully driven
  concord inverse my.toml --acceleration hinge.turn_z=2.5
      forces that give the kept coordinates these accelerations, and the way back
  concord invariance my.toml
      each solver against itself: the same machine described in equivalent ways
  concord joint --all
      a sheet for each joint type that proves or refutes it, and a summary
  concord fuzz --count 1000 --keep found
      compares random machines; failing ones are kept in found/, reduced
  concord nightly data/nightly.toml --history ~/nights.sqlite --out tonight
      runs a suite of cases, each in its own process, and compares the results with the accepted ones
  concord nightly data/nightly.toml --history ~/nights.sqlite --slurm --partition=night
      runs the same as jobs of a Slurm cluster
  concord report ~/nights.sqlite -o night.html
      the last night and all trends as one page
  concord accept data/nightly.toml --reason "first baselines"
      accepts the results of this program as the baselines
  concord history slider_crank_flexible --history ~/nights.sqlite
      the trend of a case, its steps, and the commits before and after

Exit codes: 0 agree, 1 differ, 2 bad input, 3 could not finish, 4 a baseline is missing.
Interrupted by SIGINT or SIGTERM: 128 + the signal's number.
Units are SI and radians. Model files: data/README.md; how a verdict is reached: compare/README.md.)";

/// The ranges of CLI11 let NaN through.
const CLI::Validator kNumber(
    [](std::string& text) {
      double value = 0.0;
      const bool is_number = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
      if (!is_number) return fmt::format("{} is not a finite number", text);
      return has_usable_size(value) ? std::string() : fmt::format("the number {}", complaint_about_size(value));
    },
    "");

/// A number in a range, said as a person writes it.
CLI::Validator number_in(double least, double most) {
  return CLI::Validator(
      [=](std::string& text) {
        const std::string complaint = kNumber(text);
        if (!complaint.empty()) return complaint;
        const double value = std::stod(text);
        return value >= least && value <= most ? std::string()
                                               : fmt::format("{} is not between {:g} and {:g}", text, least, most);
      },
      "");
}

const CLI::Validator kPositive(
    [](std::string& text) {
      const std::string complaint = kNumber(text);
      if (!complaint.empty()) return complaint;
      return std::stod(text) > 0.0 ? std::string() : fmt::format("{} is not above zero", text);
    },
    "");

void add_run_options(CLI::App& command, compare::VerifyOptions& options) {
  command.add_option("--until", options.until, "End of the run [s]; default: what the model says")->check(kPositive);
  command
      .add_option(
          "--rtol", options.rtol,
          "Relative tolerance of the integrators; default: what the model says, else 1e-11 rigid, 1e-9 flexible")
      ->check(number_in(kTightestTolerance, kLoosestTolerance));
  command
      .add_option("--samples", options.samples,
                  "Equal intervals of the output grid; default: what the model says, else 300; `compare` takes a "
                  "multiple that gives at least 200 states")
      ->check(CLI::Range(1, 1000000));
}

struct CommandLine {
  compare::CompareCommand compare;
  compare::RunCommand run;
  std::string solver;
  std::string integrator;
  std::filesystem::path info_model;
  compare::analyses::AnalysisCommand analysis;
  std::string linearize_at = "start";
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
  add_run_options(*command, line.compare.options);
  command->add_option("--cartesian-integrator", line.compare.options.integrators[0],
                      "Integrator of the Cartesian solver; `concord info` lists them");
  command->add_option("--relative-integrator", line.compare.options.integrators[1],
                      "Integrator of the relative solver; `concord info` lists them");
  command->add_option("--seed", line.compare.options.seed,
                      "Seed of the random states that both solvers are asked about; default: 19971025");
  command->add_flag("--all", line.compare.all_rows, "Print every component, not only the worst of each joint and side");
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
  add_run_options(*command, line.run.options);
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
  command->add_option("--seed", line.joint.seed, "Seed of the poses; default: 19971025");
  command->add_option("--poses", line.joint.poses, "How many poses; default: 20")->check(CLI::Range(1, 10000));
  command->add_option("--pose", line.joint.pose, "Only this pose of the seed, counted from 0")
      ->check(CLI::Range(0, 1000000));
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
  command->add_option("--seed", line.invariance.options.seed, "Seed of the moves and of the states; default: 19971025");
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
      ->check(CLI::Range(1, 100000))
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

CLI::App* add_analysis(CLI::App& program, CommandLine& line, const char* name, const char* about) {
  CLI::App* command = program.add_subcommand(name, about);
  command->add_option("MODEL", line.analysis.model, "Model file (TOML)")->required();
  command->add_flag("--all", line.analysis.all_rows, "Print every component, not only the worst of each side");
  command->add_option("--json", line.analysis.json, "File for the results as JSON");
  command->add_option("--out", line.analysis.out, "Folder for results: NetCDF and CSV of each solver");
  return command;
}

/// The analyses, and the one that was asked for.
class AnalysisCommands {
 public:
  AnalysisCommands(CLI::App& program, CommandLine& line) : line_(line) {
    using compare::analyses::Analysis;
    add(program, Analysis::statics, "statics", "Static equilibrium by both solvers");
    CLI::App* linearize = add(program, Analysis::linearize, "linearize",
                              "Eigenvalues and modes about the start or the equilibrium, by both solvers");
    linearize->add_option("--at", line.linearize_at, "State to linearize about; default: start")
        ->check(CLI::IsMember({"start", "equilibrium"}));
    CLI::App* kinematics = add(program, Analysis::kinematics, "kinematics",
                               "Motion and reactions of a machine whose motion is fully driven, by both solvers");
    add_run_options(*kinematics, line.analysis.options);
    CLI::App* inverse =
        add(program, Analysis::inverse, "inverse",
            "Total coordinate forces (springs and motors of the coordinate included) that give the kept\n"
            "coordinates prescribed accelerations, by both solvers");
    inverse->add_option("--acceleration", line.analysis.accelerations,
                        "joint.coordinate=value [m/s2, rad/s2]; default of every kept coordinate: 0");
  }

  /// Whether one was asked for; `line` then holds it.
  bool parsed() {
    for (const auto& [command, analysis] : commands_) {
      if (!command->parsed()) continue;
      line_.analysis.analysis = analysis;
      line_.analysis.at_equilibrium = line_.linearize_at == "equilibrium";
      return true;
    }
    return false;
  }

 private:
  CLI::App* add(CLI::App& program, compare::analyses::Analysis analysis, const char* name, const char* about) {
    commands_.emplace_back(add_analysis(program, line_, name, about), analysis);
    return commands_.back().first;
  }

  CommandLine& line_;
  std::vector<std::pair<CLI::App*, compare::analyses::Analysis>> commands_;
};

/// Puts the third opinion into the command; false if the program was built without it.
bool find_oracle(CommandLine& line) {
  line.compare.third_name = line.oracle;
#ifdef CONCORD_HAS_SIMBODY
  line.compare.make_third = compare::oracle::make_simbody;
  return true;
#else
  std::cerr << "error: --oracle simbody: this program was built without Simbody; install the package libsimbody-dev, "
               "then configure the build folder again with cmake and build\n";
  return false;
#endif
}

/// A stream that is closed would give its number to the next file that is opened, and tables would run into results.
void occupy_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) == -1 && errno == EBADF) open("/dev/null", O_RDONLY);
  }
}

/// The code, unless the tables could not be written: a full disk, a closed pipe.
int code_if_told(int code) {
  errno = 0;
  std::cout.flush();
  if (std::cout) return code;
  std::cerr << fmt::format("could not finish: the standard output cannot be written{}{}\n", errno != 0 ? ": " : "",
                           errno != 0 ? std::strerror(errno) : "");
  return compare::kCouldNotFinish;
}

/// Names a first word that is no command; CLI11 says only that a command is missing.
void require_known_command(const CLI::App& program, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands(nullptr)) names.push_back(command->get_name());
  if (std::find(names.begin(), names.end(), argv[1]) != names.end()) return;
  throw CLI::ValidationError(fmt::format("no command '{}': {}", argv[1], suggestion(argv[1], names, "commands")));
}

/// Reads the command line and does what it says.
int run_program(int argc, char** argv) {
  CLI::App program(kAbout, "concord");
  program.footer(kEpilogue);
  program.set_version_flag("--version", compare::nightly::version_words());
  program.require_subcommand(1);
  CommandLine line;
  const CLI::App* compare_command = add_compare(program, line);
  const CLI::App* run_command = add_run(program, line);
  const CLI::App* joint_command = add_joint(program, line);
  const CLI::App* invariance_command = add_invariance(program, line);
  const CLI::App* fuzz_command = compare::fuzz::add_fuzz(program, line.fuzz);
  const CLI::App* report_command = add_report(program, line);
  add_info(program, line);
  AnalysisCommands analyses(program, line);
  compare::nightly::NightlyCommands nights(program);
  try {
    require_known_command(program, argc, argv);
    program.parse(nights.take_slurm_words(argc, argv), argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? compare::kAgree : compare::kBadInput;
  }

  const compare::SolverMakers makers{cartesian::make_solver, relative::make_solver};
  const compare::Console console{std::cout, std::cerr, isatty(STDERR_FILENO) != 0};
  if (compare_command->parsed()) {
    if (!line.oracle.empty() && !find_oracle(line)) return compare::kBadInput;
    return compare::compare_models(line.compare, makers, console);
  }
  if (run_command->parsed()) {
    line.run.is_cartesian = line.solver == "cartesian";
    line.run.options.integrators[line.run.is_cartesian ? 0 : 1] = line.integrator;
    return compare::run_model(line.run, makers, console);
  }
  if (joint_command->parsed()) return compare::joint_check::check_joints(line.joint, console);
  if (invariance_command->parsed()) return compare::invariance::try_invariance(line.invariance, makers, console);
  if (report_command->parsed()) return write_report(*report_command, line, console);
  if (fuzz_command->parsed()) return compare::fuzz::fuzz_machines(line.fuzz, makers, console);
  if (const auto code = nights.run(makers, console)) return *code;
  if (analyses.parsed()) return compare::analyses::analyse_model(line.analysis, makers, console);
  return compare::show_info(line.info_model, makers, console);
}

}  // namespace

int main(int argc, char** argv) {
  occupy_standard_streams();
  std::signal(SIGPIPE, SIG_IGN);  // writing into a closed pipe fails, and is reported
  try {
    const compare::InterruptWatch watch;
    return code_if_told(run_program(argc, argv));
  } catch (const std::exception& error) {
    std::cerr << "could not finish: " << error.what() << '\n';
    return compare::kCouldNotFinish;
  }
}
