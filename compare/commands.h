#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/solver.h"
#include "compare/agreement.h"
#include "compare/third_opinion.h"
#include "compare/verify.h"

/// What the program does, free of its command line and of the solvers behind it.
namespace concord::compare {

/// Makes a solver of each kind for a model.
struct SolverMakers {
  std::function<std::unique_ptr<Solver>(const Model&)> cartesian;
  std::function<std::unique_ptr<Solver>(const Model&)> relative;
};

/// Exit codes of the program.
enum ExitCode { kAgree = 0, kDiffer = 1, kBadInput = 2, kCouldNotFinish = 3 };

/// Where the commands speak.
struct Console {
  std::ostream& out;      // tables
  std::ostream& err;      // errors, wall times
  bool progress = false;  // err is a terminal: show how far long runs are
};

/// Binds another program to a model; throws NotExpressible.
using ThirdOpinionMaker = std::function<std::unique_ptr<ThirdOpinion>(const Model&)>;

struct CompareCommand {
  std::vector<std::filesystem::path> models;
  VerifyOptions options;
  bool all_rows = false;
  std::filesystem::path out;        // empty: write no result files
  std::filesystem::path json;       // empty: write no JSON
  std::filesystem::path junit;      // empty: write no JUnit XML
  std::filesystem::path reference;  // empty: none; of one model only
  ThirdOpinionMaker make_third;     // empty: no third opinion
  std::string third_name;
};

struct RunCommand {
  std::filesystem::path model;
  bool is_cartesian = true;
  VerifyOptions options;
  std::filesystem::path out;
};

/// Compares each model and prints its table; with several models a summary of all, a failing one included. Returns the
/// worst exit code. Writes nothing about a model that cannot be read but its error into the JUnit file. Refuses outputs
/// that cannot be written before any work; JSON and JUnit files of an earlier run are removed then, because they would
/// pass for this one's.
int compare_models(const CompareCommand& command, const SolverMakers& makers, const Console& console);

/// One solver's run.
struct NamedRun {
  std::string_view solver;
  const Trajectory* trajectory = nullptr;
  /// What of it is unique; null: not known.
  const Mask* unique = nullptr;
};

/// Writes solvers' runs: NetCDF and CSV files `folder`/`model`.`solver`.nc, .motion.csv, .reactions.csv, and
/// .elements.csv if the model has force elements. They replace those of an earlier run together. Throws InputError if
/// the path cannot be written.
void write_runs(const std::filesystem::path& folder, const Model& model, const std::vector<NamedRun>& runs);

/// Throws InputError unless a file can be written at `target` (an empty one is none) that is none of the `inputs`.
void check_output(const std::filesystem::path& target, const std::vector<std::filesystem::path>& inputs);

/// Integrates one model with one solver and prints the peak reactions.
int run_model(const RunCommand& command, const SolverMakers& makers, const Console& console);

/// Prints bodies, joints, degrees of freedom, loops, cut joints, rank and uniqueness as both solvers see them.
int show_info(const std::filesystem::path& model, const SolverMakers& makers, const Console& console);

}  // namespace concord::compare
