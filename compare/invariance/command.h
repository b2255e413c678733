#pragma once

#include <filesystem>
#include <vector>

#include "compare/invariance/invariance_checks.h"
#include "compare/report/console.h"

/// `concord invariance`.
namespace concord::compare::invariance {

struct InvarianceCommand {
  std::vector<std::filesystem::path> models;
  InvarianceOptions options;
  std::filesystem::path json;  // empty: write no JSON
};

/// Holds each solver against itself on each model, prints the tables, with several models a summary; returns the worst
/// exit code.
int try_invariance(const InvarianceCommand& command, const SolverMakers& makers, const Console& console);

}  // namespace concord::compare::invariance
