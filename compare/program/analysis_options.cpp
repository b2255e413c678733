#include "compare/program/analysis_options.h"

#include "compare/analyses/command.h"
#include "compare/program/run_options.h"

namespace concord::compare {

namespace {

using analyses::Analysis;
using analyses::AnalysisCommand;

/// With what all analyses have in common; the caller adds what is an analysis' own.
CommandLine::Added<AnalysisCommand> add(CommandLine& line, Analysis analysis, const char* name, const char* about) {
  const auto added = line.add<AnalysisCommand>(name, about, analyses::analyse_model);
  added.command.analysis = analysis;
  added.app.add_option("MODEL", added.command.model, "Model file (TOML)")->required();
  added.app.add_flag("--all", added.command.all_rows, "Print every component, not only the worst of each side");
  added.app.add_option("--json", added.command.json, "File for the results as JSON");
  added.app.add_option("--out", added.command.out, "Folder for results: NetCDF and CSV of each solver");
  return added;
}

}  // namespace

void add_analyses(CommandLine& line) {
  add(line, Analysis::statics, "statics", "Static equilibrium by both solvers");
  const auto linearize = add(line, Analysis::linearize, "linearize",
                             "Eigenvalues and modes about the start or the equilibrium, by both solvers");
  linearize.app.add_option("--at", linearize.command.at, "State to linearize about; default: start")
      ->check(CLI::IsMember({"start", "equilibrium"}));
  const auto kinematics = add(line, Analysis::kinematics, "kinematics",
                              "Motion and reactions of a machine whose motion is fully driven, by both solvers");
  add_run_options(kinematics.app, kinematics.command.options);
  const auto inverse =
      add(line, Analysis::inverse, "inverse",
          "Total coordinate forces (springs and motors of the coordinate included) that give the kept\n"
          "coordinates prescribed accelerations, by both solvers");
  inverse.app.add_option("--acceleration", inverse.command.accelerations,
                         "joint.coordinate=value [m/s2, rad/s2]; default of every kept coordinate: 0");
}

}  // namespace concord::compare
