#include "compare/fuzz/command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <new>
#include <sstream>

#include "cartesian/solver.h"
#include "common/reading/model_file.h"
#include "common/reading/toml_document.h"
#include "compare/random_machines/writer.h"
#include "relative/solver.h"
#include "tests/unit/temporary_folder.h"

using namespace concord;
using namespace concord::compare;
using namespace concord::compare::fuzz;
using testing::HasSubstr;

namespace {

struct Told {
  int code = 0;
  std::string out;
  std::string err;
};

Told fuzz_with(const FuzzCommand& command, const SolverMakers& makers) {
  std::ostringstream out;
  std::ostringstream err;
  const int code = fuzz_machines(command, makers, {out, err});
  return {code, out.str(), err.str()};
}

/// Makes no solver at all, but does as it is told first; then refuses honestly.
SolverMakers makers_that(const std::function<void(const Model&)>& act) {
  const auto make = [act](const Model& model) -> std::unique_ptr<Solver> {
    act(model);
    throw SingularPose("the pose is singular");
  };
  return {make, make};
}

const SolverMakers kReal{cartesian::make_solver, relative::make_solver};

bool has_universal(const Model& model) {
  return std::any_of(model.joints.begin(), model.joints.end(),
                     [](const Joint& joint) { return joint.type->name == "universal"; });
}

}  // namespace

TEST(FuzzCommand, SeedReproducesByteForByteWhateverTheNumberOfJobs) {
  FuzzCommand command;
  command.count = 12;
  command.seed = 5;
  command.jobs = 1;
  const Told once = fuzz_with(command, kReal);
  command.jobs = 3;
  const Told again = fuzz_with(command, kReal);
  EXPECT_EQ(once.out, again.out);
  EXPECT_EQ(once.code, again.code);
  EXPECT_THAT(once.out, HasSubstr("| agree"));
  EXPECT_THAT(once.err, HasSubstr("machines per second and core"));
}

TEST(FuzzCommand, CrashHangAndGluttonyCostOneMachineEach) {
  const SolverMakers makers = makers_that([](const Model& model) {
    if (model.name == "fuzz_2") std::raise(SIGABRT);
    if (model.name == "fuzz_4") {
      for (volatile long k = 0;;) k = k + 1;
    }
    if (model.name == "fuzz_6") throw std::bad_alloc();
  });
  FuzzCommand command;
  command.count = 9;
  command.jobs = 2;
  command.seconds = 0.3;
  const Told told = fuzz_with(command, makers);
  EXPECT_EQ(told.code, 3);
  EXPECT_THAT(told.out, HasSubstr("machine 2: crashed by signal 6\n"));
  EXPECT_THAT(told.out, HasSubstr("check: start"));
  EXPECT_THAT(told.out, HasSubstr("machine 4: hung by signal 9\n"));
  EXPECT_THAT(told.out, HasSubstr("machine 6: out of memory\n"));
  EXPECT_THAT(told.out, HasSubstr("refused: singular pose |        6 |"));
}

TEST(FuzzCommand, OnlyHonestRefusalsAreNoTrouble) {
  FuzzCommand command;
  command.count = 5;
  EXPECT_EQ(fuzz_with(command, makers_that([](const Model&) {})).code, 0);
  const Told told = fuzz_with(command, makers_that([](const Model&) { throw SolverError("relative: is tired"); }));
  EXPECT_EQ(told.code, 1);
  EXPECT_THAT(told.out, HasSubstr("stop: relative: is tired"));
}

/// Finds a fault that makes every start contradict itself, so that each machine alone is refused honestly.
TEST(FuzzCommand, TooManyRefusalsAreTrouble) {
  FuzzCommand command;
  command.count = 40;
  const Told told = fuzz_with(command, makers_that([](const Model&) {}));
  EXPECT_EQ(told.code, 1);
  EXPECT_THAT(told.out, HasSubstr("100.00 % of regular machines are refused, where sound solvers refuse about 1 %"));
}

TEST(FuzzCommand, WhatEndsWronglyIsKeptAndRepeatsIt) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "fuzz_keep";
  std::filesystem::remove_all(folder);
  const SolverMakers makers = makers_that([](const Model& model) {
    if (has_universal(model)) throw SolverError("relative: dislikes crosses");
  });
  FuzzCommand command;
  command.count = 12;
  command.keep = folder;
  const Told told = fuzz_with(command, makers);
  EXPECT_EQ(told.code, 1);
  int kept = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".toml" || entry.path().string().find(".modes.") != std::string::npos) continue;
    ++kept;
    const Model model = read_model(entry.path());
    EXPECT_TRUE(has_universal(model));
    EXPECT_LE(model.elements.size() + model.couplings.size(), 0U);
    std::ifstream file(entry.path());
    std::stringstream text;
    text << file.rdbuf();
    EXPECT_THAT(text.str(), HasSubstr("# stop: relative: dislikes crosses\n# concord compare fuzz_1_"));
  }
  EXPECT_GT(kept, 0);
  EXPECT_EQ(told.out.find("is kept as") != std::string::npos, kept > 0);
}

TEST(FuzzCommand, UnknownStyleIsRefused) {
  FuzzCommand command;
  command.style = "looops";
  const Told told = fuzz_with(command, kReal);
  EXPECT_EQ(told.code, 2);
  EXPECT_THAT(told.err, HasSubstr("no style 'looops'"));
}

TEST(FuzzCommand, OneMachineIsPrintedAsAModelThatReads) {
  FuzzCommand command;
  command.print = true;
  command.first = 4;
  const Told told = fuzz_with(command, kReal);
  EXPECT_EQ(told.code, 0);
  EXPECT_THAT(told.out, HasSubstr("format = 1\nname = \"fuzz_4\"\n"));
}

TEST(FuzzCommand, AMachineWithModesFilesIsWrittenWholeOrSaidToLackThem) {
  FuzzCommand command;
  command.print = true;
  command.style = "flexible";
  command.seed = 77;
  while (write_machine(draw_machine(command.seed, command.first, Style::flexible)).beside.empty()) {
    ++command.first;
  }
  const Told printed = fuzz_with(command, kReal);
  EXPECT_THAT(printed.err, HasSubstr("not printed: --keep FOLDER writes all files"));
  EXPECT_NO_THROW(static_cast<void>(parse_toml(printed.out, "printed.toml")));
  const TemporaryFolder folder;
  command.keep = folder.path();
  const Told kept = fuzz_with(command, kReal);
  EXPECT_EQ(kept.code, 0);
  EXPECT_FALSE(read_model(kept.out.substr(0, kept.out.find('\n'))).bodies.empty());
}
