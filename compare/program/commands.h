#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/model.h"
#include "compare/quantities/third_opinion.h"
#include "compare/report/console.h"
#include "compare/states/branch.h"
#include "compare/verdict/verify.h"

/// What the program does, free of its command line and of the solvers behind it.
namespace concord::compare {

/// Binds another program to a model; throws NotExpressible.
using ThirdOpinionMaker = std::function<std::unique_ptr<ThirdOpinion>(const Model&)>;

struct CompareCommand {
  std::vector<std::filesystem::path> models;
  VerifyOptions options;
  bool all_rows = false;
  std::string axes = {};            // "world" or a body in whose axes wrenches are told; empty: each side's frame
  std::filesystem::path out;        // empty: write no result files
  std::filesystem::path json;       // empty: write no JSON
  std::filesystem::path junit;      // empty: write no JUnit XML
  std::filesystem::path report;     // empty: write no page
  std::filesystem::path reference;  // empty: none; of one model only
  ThirdOpinionMaker make_third;     // empty: no third opinion
  std::string third_name;
};

struct RunCommand {
  std::filesystem::path model;
  std::string solver = {};      // "cartesian" or "relative"; empty: each of them alone, one after the other
  std::string integrator = {};  // of the solver that is named; empty: its first one
  VerifyOptions options;
  std::filesystem::path out;
  std::string axes = {};  // as those of a comparison
};

/// Compares each model and prints its table; with several models a summary of all, a failing one included. Returns the
/// worst exit code. Writes nothing about a model that cannot be read but its error into the JUnit file. Refuses outputs
/// that cannot be written before any work; JSON and JUnit files and a page of an earlier run are removed then, because
/// they would pass for this one's.
int compare_models(const CompareCommand& command, const SolverMakers& makers, const Console& console);

/// Integrates one model with one solver, or with each alone, and prints the peak reactions. Writes all or nothing.
int run_model(const RunCommand& command, const SolverMakers& makers, const Console& console);

/// Prints bodies, joints, degrees of freedom, loops, cut joints, rank and uniqueness as both solvers see them.
int show_info(const std::filesystem::path& model, const SolverMakers& makers, const Console& console);

}  // namespace concord::compare
