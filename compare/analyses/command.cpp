#include "compare/analyses/command.h"

#include <fmt/format.h>

#include <cmath>
#include <ostream>

#include "common/reading/model_file.h"
#include "compare/analyses/report.h"
#include "compare/report/colours.h"
#include "compare/report/console.h"
#include "compare/report/files.h"
#include "compare/report/result_folder.h"
#include "compare/report/whole_number.h"
#include "compare/states/near_frames.h"

namespace concord::compare::analyses {

namespace {

/// "joint.coordinate=value".
AskedAcceleration read_asked(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  const std::size_t dot = equals == std::string::npos ? std::string::npos : text.rfind('.', equals);
  if (dot != std::string::npos) {
    // The last dot before '=' ends the joint's name.
    const auto value = whole_text_as<double>(text.substr(equals + 1));
    if (value && std::isfinite(*value)) return {text.substr(0, dot), text.substr(dot + 1, equals - dot - 1), *value};
  }
  throw InputError({"--acceleration", 0, 0},
                   fmt::format("'{}': expected joint.coordinate=number, such as hinge.turn_z=2.5 [rad/s2]", text));
}

AnalysisVerdict judge(const AnalysisCommand& command, const Model& model, const SolverMakers& makers) {
  switch (command.analysis) {
    case Analysis::statics:
      return judge_statics(model, makers);
    case Analysis::linearize:
      return judge_linearization(model, makers, command.at == "equilibrium");
    case Analysis::kinematics:
      return judge_kinematics(model, makers, command.options);
    default: {
      std::vector<AskedAcceleration> asked;
      for (const std::string& text : command.accelerations) asked.push_back(read_asked(text));
      return judge_inverse(model, makers, asked);
    }
  }
}

/// Refuses what cannot be written, and removes what an earlier run wrote there.
void prepare_outputs(const AnalysisCommand& command) {
  check_output(command.json, {command.model});
  if (!command.out.empty()) check_target_folder(command.out);
  if (!command.json.empty()) std::filesystem::remove(command.json);
}

/// Runs of both solvers, of the machine that made them, and of a linearization the modes of each.
void write_results(const std::filesystem::path& folder, const Model& model, const AnalysisVerdict& result) {
  make_folder(folder);
  std::vector<NamedRun> runs;
  for (std::size_t who = 0; who < 2; ++who) {
    const std::string& solver = result.wrenches.solvers[who].name;
    const auto& unique = result.wrenches.unique;
    if (const auto& run = result.wrenches.trajectories[who])
      runs.push_back({solver, &*run, unique ? &*unique : nullptr});
    if (const auto& found = result.linearizations[who]) {
      write_file(folder / fmt::format("{}.{}.modes.csv", model.name, solver), format_modes_csv(model, *found));
    }
  }
  if (!runs.empty()) write_runs(folder, result.machine ? *result.machine : model, runs);
}

}  // namespace

int analyse_model(const AnalysisCommand& command, const SolverMakers& makers, const Console& console) {
  return guarded(console, [&] {
    prepare_outputs(command);
    const NearFrames near(read_model(command.model));
    const Model& model = near.model();
    AnalysisVerdict result = judge(command, model, makers);
    result.wrenches.trajectories = near.back(std::move(result.wrenches.trajectories));
    if (!near.note().empty()) result.text = fmt::format("note: {}\n{}", near.note(), result.text);
    for (const std::string& note : model.notes) console.out << fmt::format("note: {}\n", note);
    console.out << shown(console, format_analysis(model, result, command.all_rows)) << std::flush;
    if (!command.out.empty()) write_results(command.out, model, result);
    if (!command.json.empty()) write_file(command.json, format_analysis_json(model, result));
    return exit_code(result.wrenches.outcome);
  });
}

}  // namespace concord::compare::analyses
