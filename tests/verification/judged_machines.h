#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cartesian/solver.h"
#include "common/reading/model_file.h"
#include "compare/report/table.h"
#include "compare/verdict/verify.h"
#include "relative/solver.h"

/// Machines that stand beside the tests, tests/verification/machines, and verdicts on them.
namespace concord::verification {

inline std::filesystem::path machines_folder(const std::string& folder) {
  return std::filesystem::path(CONCORD_SOURCE) / "tests" / "verification" / "machines" / folder;
}

/// Names of the model files of a folder, without the ending, in order; parts and modes files lie in subfolders.
inline std::vector<std::string> machines_of(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(machines_folder(folder))) {
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

inline Model machine_of(const std::string& folder, const std::string& name) {
  return read_model(machines_folder(folder) / (name + ".toml"));
}

inline compare::Verdict judged(const Model& model, const compare::VerifyOptions& options) {
  const auto cartesian_solver = cartesian::make_solver(model);
  const auto relative_solver = relative::make_solver(model);
  return compare::verify(model, *cartesian_solver, *relative_solver, options);
}

/// What takes seconds for all machines of a folder: a part of the run, few samples and states, all checks.
inline compare::VerifyOptions in_short(const Model& model, double part) {
  compare::VerifyOptions options;
  options.until = part * model.run.until;
  options.samples = 20;
  options.states = 40;
  return options;
}

/// Prints the last line of the table, and expects a machine of which something is judged to agree.
inline void expect_to_agree(const Model& model, const compare::VerifyOptions& options) {
  const compare::Verdict verdict = judged(model, options);
  const std::string table = compare::format_verdict(model, verdict, false);
  std::printf("%s", table.substr(table.rfind('\n', table.size() - 2) + 1).c_str());
  std::fflush(stdout);
  INFO(table);
  CHECK(verdict.outcome == compare::Outcome::agree);
  CHECK(verdict.judged > 0);
}

inline std::size_t joint_named(const Model& model, const std::string& name) {
  const auto found =
      std::find_if(model.joints.begin(), model.joints.end(), [&](const Joint& joint) { return joint.name == name; });
  REQUIRE(found != model.joints.end());
  return static_cast<std::size_t>(found - model.joints.begin());
}

}  // namespace concord::verification
