#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/analyses/judge.h"
#include "compare/verdict/verdict.h"

/// Result files read back, by names and places that are written down here once more, from the tables of the manual:
/// nothing is shared with the code that writes them. Every cell must be the number of the run, to its last digit.
namespace concord::read_back {

/// A solver's run in memory. `unique`: rows in the order in which the comparator lists its quantities, columns: the
/// samples; null: not known.
struct Run {
  const Model& model;
  std::string solver;
  const Trajectory& trajectory;
  const compare::Mask* unique = nullptr;
};

/// What in the files of a run (.nc, .motion.csv, .reactions.csv, .elements.csv) is not that run: a line for each file
/// and column, "crank.relative.reactions.csv: A.tau_1 [N m]: -2.5 in line 3, the run has 2.5". Empty: all is.
std::vector<std::string> unlike_run(const std::filesystem::path& folder, const Run& run);

/// The same of .modes.csv of a linearization.
std::vector<std::string> unlike_modes(const std::filesystem::path& file, const Model& model,
                                      const compare::analyses::Linearization& found);

/// The same of .result.json, and of the file of --json, of a comparison.
std::vector<std::string> unlike_result(const std::filesystem::path& file, const Model& model,
                                       const compare::Verdict& verdict);
std::vector<std::string> unlike_verdict(const std::filesystem::path& file, const Model& model,
                                        const compare::Verdict& verdict);

/// The same of the file of --json of an analysis.
std::vector<std::string> unlike_analysis(const std::filesystem::path& file, const Model& model,
                                         const compare::analyses::AnalysisVerdict& result);

}  // namespace concord::read_back
