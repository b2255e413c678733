#pragma once

#include <filesystem>
#include <vector>

#include "compare/analyses/inverse.h"
#include "compare/report/console.h"
#include "compare/states/branch.h"
#include "compare/verdict/verify.h"

/// `concord statics`, `linearize`, `kinematics`, `inverse`.
namespace concord::compare::analyses {

enum class Analysis { statics, linearize, kinematics, inverse };

struct AnalysisCommand {
  Analysis analysis = Analysis::statics;
  std::filesystem::path model;
  std::string at = "start";                // or "equilibrium": linearize
  std::vector<std::string> accelerations;  // inverse: "joint.coordinate=value"
  VerifyOptions options;                   // kinematics: until, samples
  bool all_rows = false;
  std::filesystem::path out;   // empty: write no result files
  std::filesystem::path json;  // empty: write no JSON
};

/// Does the analysis by both solvers, prints what was found and how far they agree; returns the exit code.
int analyse_model(const AnalysisCommand& command, const SolverMakers& makers, const Console& console);

}  // namespace concord::compare::analyses
