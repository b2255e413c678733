#include "compare/program/analysis_options.h"

#include <CLI/CLI.hpp>

#include "compare/program/run_options.h"

namespace concord::compare {

using analyses::Analysis;

AnalysisCommands::AnalysisCommands(CLI::App& program) {
  add(program, Analysis::statics, "statics", "Static equilibrium by both solvers");
  CLI::App* linearize = add(program, Analysis::linearize, "linearize",
                            "Eigenvalues and modes about the start or the equilibrium, by both solvers");
  linearize->add_option("--at", linearize_at_, "State to linearize about; default: start")
      ->check(CLI::IsMember({"start", "equilibrium"}));
  CLI::App* kinematics = add(program, Analysis::kinematics, "kinematics",
                             "Motion and reactions of a machine whose motion is fully driven, by both solvers");
  add_run_options(*kinematics, command_.options);
  CLI::App* inverse = add(program, Analysis::inverse, "inverse",
                          "Total coordinate forces (springs and motors of the coordinate included) that give the kept\n"
                          "coordinates prescribed accelerations, by both solvers");
  inverse->add_option("--acceleration", command_.accelerations,
                      "joint.coordinate=value [m/s2, rad/s2]; default of every kept coordinate: 0");
}

const analyses::AnalysisCommand* AnalysisCommands::parsed() {
  for (const auto& [command, analysis] : commands_) {
    if (!command->parsed()) continue;
    command_.analysis = analysis;
    command_.at_equilibrium = linearize_at_ == "equilibrium";
    return &command_;
  }
  return nullptr;
}

CLI::App* AnalysisCommands::add(CLI::App& program, Analysis analysis, const char* name, const char* about) {
  CLI::App* command = program.add_subcommand(name, about);
  command->add_option("MODEL", command_.model, "Model file (TOML)")->required();
  command->add_flag("--all", command_.all_rows, "Print every component, not only the worst of each side");
  command->add_option("--json", command_.json, "File for the results as JSON");
  command->add_option("--out", command_.out, "Folder for results: NetCDF and CSV of each solver");
  commands_.emplace_back(command, analysis);
  return command;
}

}  // namespace concord::compare
