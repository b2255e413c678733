#include <fmt/format.h>
#include <unistd.h>

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
#include "compare/program/frame.h"
#include "compare/report/option_limits.h"
#include "compare/report/origin.h"
#include "compare/report/whole_number.h"
#include "relative/solver.h"

/// The command line of `concord-campaigns`, which `concord` becomes where one of its commands is asked for.
namespace {

using namespace concord;

struct CommandLine {
  compare::joint_check::JointCommand joint;
  compare::invariance::InvarianceCommand invariance;
  compare::fuzz::FuzzCommand fuzz;
  std::filesystem::path report_of;  // a folder of results, or a history
  compare::nightly::NightReportCommand night_report;
};

CLI::App* add_joint(CLI::App& program, CommandLine& line) {
  CLI::App* command = program.add_subcommand("joint");
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
  CLI::App* command = program.add_subcommand("invariance");
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
  CLI::App* command = program.add_subcommand("report");
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

/// Reads the command line and does what it says.
int run_program(int argc, char** argv) {
  CLI::App program("The commands of concord beside compare, run and info; call them as `concord COMMAND ...`.",
                   "concord");
  program.set_version_flag("--version", compare::version_words());
  program.require_subcommand(1);
  CommandLine line;
  compare::AnalysisCommands analyses(program);
  const CLI::App* joint_command = add_joint(program, line);
  const CLI::App* invariance_command = add_invariance(program, line);
  const CLI::App* fuzz_command = compare::fuzz::add_fuzz(program, line.fuzz);
  compare::nightly::NightlyCommands nights(program);
  const CLI::App* report_command = add_report(program, line);
  for (const auto& [name, about] : compare::kCampaignCommands) program.get_subcommand(name)->description(about);
  compare::add_examples(program);
  try {
    compare::require_known_command(program, argc, argv);
    program.parse(nights.take_slurm_words(argc, argv), argv);
    compare::require_values(program);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? compare::kAgree : compare::kBadInput;
  }

  const compare::SolverMakers makers{cartesian::make_solver, relative::make_solver};
  const compare::Console console{std::cout, std::cerr, compare::can_show_progress()};
  if (const auto* analysis = analyses.parsed()) return compare::analyses::analyse_model(*analysis, makers, console);
  if (joint_command->parsed()) return compare::joint_check::check_joints(line.joint, console);
  if (invariance_command->parsed()) return compare::invariance::try_invariance(line.invariance, makers, console);
  if (fuzz_command->parsed()) return compare::fuzz::fuzz_machines(line.fuzz, makers, console);
  if (report_command->parsed()) return write_report(*report_command, line, console);
  return nights.run(makers, console).value_or(compare::kBadInput);
}

}  // namespace

int main(int argc, char** argv) {
  return compare::run_guarded([&] { return run_program(argc, argv); });
}
