#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "closed_forms.h"
#include "compare/analyses/command.h"
#include "compare/equilibrium/started_machine.h"
#include "compare/program/commands.h"
#include "compare/resolution/run_check.h"
#include "compare/states/near_frames.h"
#include "compare/states/stiff_choice.h"
#include "tests/read_back/read_back.h"

/// Every file that commands write into --out, read back by code of its own (tests/read_back) and held against runs that
/// are made once more in memory: same options, same numbers, to the last digit.
namespace concord::verification {
namespace {

namespace fs = std::filesystem;
using compare::VerifyOptions;
using compare::Who;
using compare::analyses::Analysis;

const fs::path kModels = fs::path(CONCORD_DATA) / "models";

/// A folder of this test alone; while it lives no program is found, so that no plots are drawn: pictures are not read
/// back, and take longer than all else.
class Results {
 public:
  Results() : folder(fs::temp_directory_path() / ("concord_read_back_" + std::to_string(getpid()))) {
    fs::remove_all(folder);
    fs::create_directories(folder);
    const char* found = std::getenv("PATH");
    path_ = found != nullptr ? found : "";
    setenv("PATH", "", 1);
  }
  ~Results() {
    setenv("PATH", path_.c_str(), 1);
    fs::remove_all(folder);
  }
  Results(const Results&) = delete;
  Results& operator=(const Results&) = delete;

  const fs::path folder;

 private:
  std::string path_;
};

const compare::SolverMakers& makers() {
  static const compare::SolverMakers both{cartesian::make_solver, relative::make_solver};
  return both;
}

std::vector<fs::path> shipped_models() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(kModels)) {
    if (entry.path().extension() == ".toml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  REQUIRE(files.size() > 40);
  return files;
}

/// Few samples and states: what is read back does not are attached by what is found.
VerifyOptions short_run(const Model& model) {
  VerifyOptions options;
  options.until = std::min(model.run.until, 0.02);
  options.samples = 5;
  options.states = 5;
  options.refines = false;
  return options;
}

void append(std::vector<std::string>& all, const std::vector<std::string>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

/// What in the files of `concord compare --out` and --json is not what a comparison in memory finds.
std::vector<std::string> unlike_comparison(const fs::path& file, const VerifyOptions& options) {
  const Results results;
  compare::CompareCommand command;
  command.models = {file};
  command.options = options;
  command.out = results.folder / "out";
  command.json = results.folder / "verdict.json";
  std::ostringstream out;
  std::ostringstream err;
  compare_models(command, makers(), {out, err});

  const Model model = read_model(file);
  const compare::StartedMachine machine(model, makers());
  VerifyOptions own = options;
  own.makers = &makers();
  compare::Verdict verdict =
      verify(machine.model(), machine.solver(Who::cartesian), machine.solver(Who::relative), own);
  verdict.notes.insert(verdict.notes.end(), machine.notes().begin(), machine.notes().end());
  std::vector<std::string> unlike;
  for (std::size_t who = 0; who < 2; ++who) {
    auto& run = verdict.trajectories[who];
    if (!run) {
      unlike.emplace_back("no run");
      continue;
    }
    run = machine.back(std::move(*run));
    append(unlike, read_back::unlike_run(command.out, {model, verdict.solvers[who].name, *run,
                                                       verdict.unique ? &*verdict.unique : nullptr}));
  }
  append(unlike, read_back::unlike_result(command.out / (model.name + ".result.json"), model, verdict));
  append(unlike, read_back::unlike_verdict(command.json, model, verdict));
  std::ifstream table(command.out / (model.name + ".table.txt"));
  std::ostringstream text;
  text << table.rdbuf();
  if (text.str() != out.str()) unlike.emplace_back("table.txt: is not what was printed");
  return unlike;
}

/// The same of `concord run --out`.
std::vector<std::string> unlike_single_run(const fs::path& file, Who who, const VerifyOptions& options) {
  const Results results;
  std::ostringstream out;
  std::ostringstream err;
  const int code =
      run_model({file, compare::kSolverNames[static_cast<std::size_t>(index(who))], {}, options, results.folder},
                makers(), {out, err});
  if (code != compare::kAgree) return {"run: " + out.str() + err.str()};

  const Model model = read_model(file);
  const compare::StartedMachine machine(model, makers());
  Solver& solver = machine.solver(who);
  RunOptions run = run_options(machine.model(), options);
  run.integrator = compare::chosen_integrator(machine.model(), solver, "");
  compare::MadeBy made_by;
  const Trajectory trajectory = integrate_or_switch(
      solver, run, true, [](double) {}, made_by);
  run.integrator = made_by.integrator;
  const compare::QuantityLayout layout(machine.model());
  const compare::RunCheck check = check_run(layout, solver, trajectory, run);
  const Trajectory back = machine.back(trajectory);
  return read_back::unlike_run(results.folder, {model, std::string(solver.name()), back, &check.unique});
}

compare::analyses::AnalysisVerdict judge(Analysis analysis, const Model& model, const VerifyOptions& options) {
  switch (analysis) {
    case Analysis::statics:
      return compare::analyses::judge_statics(model, makers());
    case Analysis::linearize:
      return compare::analyses::judge_linearization(model, makers(), false);
    case Analysis::kinematics:
      return compare::analyses::judge_kinematics(model, makers(), options);
    default:
      return compare::analyses::judge_inverse(model, makers(), {});
  }
}

/// The same of `concord statics`, `linearize`, `kinematics`, `inverse` with --out and --json.
std::vector<std::string> unlike_analysis(const fs::path& file, Analysis analysis, const VerifyOptions& options) {
  const compare::NearFrames near(read_model(file));
  const Model& model = near.model();
  compare::analyses::AnalysisVerdict result;
  try {
    result = judge(analysis, model, options);
  } catch (const SolverError&) {
    return {"refused"};
  }
  const Results results;
  compare::analyses::AnalysisCommand command;
  command.analysis = analysis;
  command.model = file;
  command.options = options;
  command.out = results.folder / "out";
  command.json = results.folder / "analysis.json";
  std::ostringstream out;
  std::ostringstream err;
  analyse_model(command, makers(), {out, err});

  std::vector<std::string> unlike;
  for (std::size_t who = 0; who < 2; ++who) {
    const std::string& solver = result.wrenches.solvers[who].name;
    const auto& unique = result.wrenches.unique;
    if (const auto& run = result.wrenches.trajectories[who]) {
      append(unlike, read_back::unlike_run(command.out, {result.machine ? *result.machine : model, solver,
                                                         near.back(*run), unique ? &*unique : nullptr}));
    }
    if (const auto& found = result.linearizations[who]) {
      const fs::path modes = command.out / (model.name + "." + solver + ".modes.csv");
      append(unlike, read_back::unlike_modes(modes, model, *found));
    }
  }
  append(unlike, read_back::unlike_analysis(command.json, model, result));
  return unlike;
}

void expect_none(const std::string& what, const std::vector<std::string>& unlike) {
  INFO(what);
  for (const std::string& one : unlike) {
    UNSCOPED_INFO(one);
  }
  CHECK(unlike.empty());
}

/// Of the shipped machines without, or of the variants of the car alone, which take as long as all others.
void expect_read_back(bool is_variant_of_car) {
  int count = 0;
  for (const fs::path& file : shipped_models()) {
    const std::string name = file.filename().string();
    if (name.starts_with("car_") != is_variant_of_car) continue;
    const VerifyOptions options = short_run(read_model(file));
    expect_none("compare " + name, unlike_comparison(file, options));
    const Who who = count++ % 2 == 0 ? Who::cartesian : Who::relative;
    expect_none("run " + name, unlike_single_run(file, who, options));
  }
}

TEST_CASE("Every number that a comparison and a run of a shipped machine write is the run's, in its column and row") {
  expect_read_back(false);
}

TEST_CASE("Every number that a comparison and a run of a variant of the car write is the run's", "[nightly]") {
  expect_read_back(true);
}

TEST_CASE("Every number that a linearization of a shipped machine writes is the one found, modes included") {
  int linearized = 0;
  for (const fs::path& file : shipped_models()) {
    const std::string name = file.filename().string();
    if (name.starts_with("car")) continue;  // slow
    const std::vector<std::string> unlike = unlike_analysis(file, Analysis::linearize, {});
    if (unlike == std::vector<std::string>{"refused"}) continue;
    ++linearized;
    expect_none("linearize " + name, unlike);
  }
  CHECK(linearized > 30);
}

TEST_CASE("Every number that statics, kinematics and inverse dynamics write is the one found") {
  for (const char* name : {"cantilever_under_gravity", "two_hinge_door", "flexible_frame_on_springs"}) {
    expect_none(std::string("statics ") + name,
                unlike_analysis(kModels / (name + std::string(".toml")), Analysis::statics, {}));
  }
  for (const char* name : {"driven_linkage", "universal_shaft_30deg", "slider_crank_rigid"}) {
    const fs::path file = kModels / (name + std::string(".toml"));
    expect_none(std::string("kinematics ") + name,
                unlike_analysis(file, Analysis::kinematics, short_run(read_model(file))));
  }
  for (const char* name : {"slider_crank_redundant", "compound_pendulum", "joint_springs_tree"}) {
    expect_none(std::string("inverse ") + name,
                unlike_analysis(kModels / (name + std::string(".toml")), Analysis::inverse, {}));
  }
}

TEST_CASE("Every number that a whole run of a flexible frame on springs writes is the run's", "[nightly]") {
  const fs::path file = kModels / "flexible_frame_on_springs.toml";
  expect_none("compare", unlike_comparison(file, {}));
  expect_none("run", unlike_single_run(file, Who::relative, {}));
  expect_none("statics", unlike_analysis(file, Analysis::statics, {}));
  expect_none("linearize", unlike_analysis(file, Analysis::linearize, {}));
}

}  // namespace
}  // namespace concord::verification
