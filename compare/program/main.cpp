#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <string_view>

#include "cartesian/solver.h"
#include "compare/program/commands.h"
#include "compare/program/examples.h"
#include "compare/program/frame.h"
#include "compare/program/run_options.h"
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

/// Reads the command line and does what it says.
int run_program(int argc, char** argv) {
  CLI::App program(kAbout, "concord");
  program.footer(compare::first_examples() + '\n' + kEpilogue);
  program.set_version_flag("--version", compare::version_words());
  program.require_subcommand(1);
  CommandLine line;
  const CLI::App* compare_command = add_compare(program, line);
  const CLI::App* run_command = add_run(program, line);
  add_info(program, line);
  for (const auto& [name, about] : compare::kCampaignCommands) program.add_subcommand(name, about);
  compare::add_examples(program);
  try {
    compare::require_known_command(program, argc, argv);
    program.parse(argc, argv);
    compare::require_values(program);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? compare::kAgree : compare::kBadInput;
  }

  const compare::SolverMakers makers{cartesian::make_solver, relative::make_solver};
  const compare::Console console{std::cout, std::cerr, compare::can_show_progress()};
  if (compare_command->parsed()) {
    if (!line.oracle.empty() && !find_oracle(line)) return compare::kBadInput;
    return compare::compare_models(line.compare, makers, console);
  }
  if (run_command->parsed()) {
    line.run.is_cartesian = line.solver == "cartesian";
    line.run.options.integrators[line.run.is_cartesian ? 0 : 1] = line.integrator;
    return compare::run_model(line.run, makers, console);
  }
  return compare::show_info(line.info_model, makers, console);
}

}  // namespace

int main(int argc, char** argv) {
  const auto is_asked_for = [&](const compare::CampaignCommand& command) {
    return argc > 1 && std::string_view(argv[1]) == command.name;
  };
  if (std::ranges::any_of(compare::kCampaignCommands, is_asked_for)) return compare::become_campaigns(argv);
  return compare::run_guarded([&] { return run_program(argc, argv); });
}
