#include "compare/nightly/suite.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "cartesian/solver.h"
#include "common/error.h"
#include "compare/nightly/case_model.h"
#include "compare/nightly/trial.h"
#include "compare/report/files.h"
#include "relative/solver.h"
#include "tests/unit/temporary_folder.h"

namespace concord::compare::nightly {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kPendulum = R"(format = 1
gravity = [0.3, -9.81, 0.2]
[parameters]
mass = 1.3
arm = 0.2
[[body]]
name = "bob"
mass = "mass"
center_of_mass = ["arm", 0.1, -0.05]
inertia = [0.02, 0.03, 0.04]
[[joint]]
name = "hinge"
type = "revolute"
parent = "ground"
child = "bob"
start.turn_z = { keep = 0.4, keep_speed = 2 }
)";

class Suites : public ::testing::Test {
 protected:
  Suites() {
    write_file(folder_.path() / "models" / "one.toml", kPendulum);
    write_file(folder_.path() / "models" / "two.toml", kPendulum);
  }

  Suite read(const std::string& text) {
    write_file(folder_.path() / "suite.toml", "format = 1\n" + text);
    return read_suite(folder_.path() / "suite.toml");
  }

  std::vector<std::string> ids(const std::string& text) {
    std::vector<std::string> all;
    for (const Case& one : read(text).cases) all.push_back(one.id);
    return all;
  }

  std::string refusal(const std::string& text) {
    try {
      read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
};

}  // namespace

TEST_F(Suites, GlobsVariantsAndWorksAreToldApartByName) {
  EXPECT_THAT(ids("[[case]]\nmodels = [\"models/*.toml\"]\n"), ElementsAre("one", "two"));
  EXPECT_THAT(ids("[[case]]\nmodels = [\"models/*.toml\"]\nexcept = [\"models/t*.toml\"]\n"), ElementsAre("one"));
  EXPECT_THAT(ids("[[case]]\nwork = \"statics\"\nmodels = [\"models/one.toml\"]\n"), ElementsAre("statics/one"));
  EXPECT_THAT(ids("[[case]]\nname = \"p\"\nmodels = [\"models/*.toml\"]\n"), ElementsAre("p/one", "p/two"));
  EXPECT_THAT(
      ids("[[case]]\nmodels = [\"models/one.toml\"]\n[case.sweep]\nparameters.mass = [1, 2]\n"
          "rtol = [1e-9, 1e-11]\n"),
      ElementsAre("one/mass=1,rtol=1e-09", "one/mass=1,rtol=1e-11", "one/mass=2,rtol=1e-09", "one/mass=2,rtol=1e-11"));
  EXPECT_THAT(ids("[[case]]\nmodels = [\"models/one.toml\"]\n[case.sweep]\ncut = { here = [\"hinge\"] }\n"
                  "integrators = [[\"ida\", \"gauss\"]]\nstart = { seed = 4, count = 2, turn = 0.1 }\n"),
              ElementsAre("one/cut=here,ida+gauss,start=0", "one/cut=here,ida+gauss,start=1"));
  EXPECT_THAT(ids("[[case]]\nwork = \"fuzz\"\nseed = 3\ncount = 10\nshares = 2\n"),
              ElementsAre("fuzz/seed=3/first=0", "fuzz/seed=3/first=10"));
}

// Detects a checks whose rows do not reach the night's memory, and moves that do not apply but have a row.
TEST_F(Suites, AnInvarianceCaseHasAComponentForEachMoveAndSolver) {
  const Suite suite = read("[[case]]\nwork = \"invariance\"\nmodels = [\"models/one.toml\"]\n");
  ASSERT_EQ(suite.cases.size(), 1U);
  EXPECT_EQ(suite.cases[0].id, "invariance/one");
  const Result result = try_case(suite.cases[0], folder_.path(), {cartesian::make_solver, relative::make_solver});
  EXPECT_EQ(result.ending, Ending::agree) << result.words;
  EXPECT_EQ(result.work, "invariance");
  std::vector<std::string> names;
  for (const Component& component : result.components) {
    names.push_back(component.name);
    EXPECT_GE(component.same_state.value_or(0.0), 10.0) << component.name;
    EXPECT_EQ(component.need[0], 10.0);
  }
  std::sort(names.begin(), names.end());
  EXPECT_THAT(names, ElementsAre("frames, cartesian", "frames, relative", "joint frames, cartesian",
                                 "joint frames, relative", "sides, cartesian", "sides, relative", "split, cartesian",
                                 "split, relative", "units, cartesian", "units, relative", "welds, cartesian",
                                 "welds, relative", "world, cartesian", "world, relative"));
}

// Detects rows of the driven machine that are sought in the layout of the machine that is not driven.
TEST_F(Suites, AnInverseCaseHasTheForceThatDrives) {
  const Suite suite = read("[[case]]\nwork = \"inverse\"\nmodels = [\"models/one.toml\"]\n");
  const Result result = try_case(suite.cases.at(0), folder_.path(), {cartesian::make_solver, relative::make_solver});
  EXPECT_EQ(result.ending, Ending::agree) << result.words;
  const auto drive = std::find_if(result.components.begin(), result.components.end(),
                                  [](const Component& one) { return one.name.find("driver") != std::string::npos; });
  ASSERT_NE(drive, result.components.end());
  EXPECT_GT(drive->peak.value_or(0.0), 0.0);
}

TEST_F(Suites, CasesMayHaveAnAllowanceOfTheirOwn) {
  const Suite suite = read(R"([judge]
margin = 1.5
[[case]]
models = ["models/*.toml"]
judge = { cost = 0.5 }
[[case]]
work = "statics"
models = ["models/one.toml"]
)");
  const Allowance& own = suite.judging.allowance_of("one");
  EXPECT_EQ(own.margin, 1.5);  // as the suite says
  EXPECT_EQ(own.cost, 0.5);
  EXPECT_EQ(suite.judging.allowance_of("two").cost, 0.5);
  EXPECT_EQ(suite.judging.allowance_of("statics/one").cost, 0.15);
  EXPECT_THAT(refusal("[[case]]\nmodels = [\"models/one.toml\"]\njudge = { cost = 0.5, nights = 3 }\n"),
              HasSubstr("suite.toml:4:23: error: case, judge: unknown key 'nights'"));
}

TEST_F(Suites, WhatIsWrongIsToldAtItsPlace) {
  EXPECT_THAT(refusal("[[case]]\nmodels = [\"models/none*.toml\"]\n"),
              HasSubstr("suite.toml:3:10: error: case: there is no file 'models/none*.toml'"));
  EXPECT_THAT(refusal("[[case]]\nmodel = [\"x\"]\n"), HasSubstr("suite.toml:3:"));
  EXPECT_THAT(refusal("[[case]]\nmodels = [\"models/one.toml\"]\nparameters = { masss = 2 }\n"),
              HasSubstr("has no parameter 'masss': did you mean 'mass'?"));
  EXPECT_THAT(refusal("[[case]]\nmodels = [\"models/one.toml\"]\n[[case]]\nmodels = [\"models/one.toml\"]\n"),
              HasSubstr("there is a case 'one' already (line 2): give one of them another name"));
  EXPECT_THAT(refusal("[[case]]\nwork = \"static\"\nmodels = [\"models/one.toml\"]\n"),
              HasSubstr("no work 'static': did you mean 'statics'?"));
  EXPECT_THAT(refusal("[[case]]\nmodels = [\"models/one.toml\"]\nknown_red = { reason = \"x\", until = \"soon\" }\n"),
              HasSubstr("'until' must be a date without quotes, such as 2026-12-31"));
  EXPECT_THAT(refusal("[[case]]\nname = \"a\\nb\"\nmodels = [\"models/one.toml\"]\n"),
              HasSubstr("'name' must be one line that is not empty, found \"a\\nb\""));
  EXPECT_THAT(refusal("[[case]]\nname = \"\"\nmodels = [\"models/one.toml\"]\n"), HasSubstr("suite.toml:3:8: error"));
  EXPECT_THAT(refusal("[[case]]\nmodels = [\"models/one.toml\"]\nsweep = { rtol = [] }\n"),
              HasSubstr("'rtol' is an empty list: it sweeps nothing"));
  EXPECT_THAT(refusal("[[case]]\nmodels = [\"models/one.toml\"]\nsweep = { rtol = [1e-7, 1e-7] }\n"),
              AllOf(HasSubstr("suite.toml:4:18: error: case, sweep: 'rtol' sweeps 1e-07 twice"),
                    Not(HasSubstr("there is a case"))));
  EXPECT_THAT(refusal("[[case]]\nmodels = [\"models/*.toml\"]\nexcept = [\"models/*\"]\n"),
              HasSubstr("suite.toml:4:10: error: case: leaves none of the files that 'models' names"));
  EXPECT_THAT(refusal("name = \"\"\n[[case]]\nmodels = [\"models/one.toml\"]\n"), HasSubstr("suite.toml:2:8: error"));
  const std::string twice = refusal(
      "[[case]]\nmodels = [\"models/one.toml\"]\nsweep.integrators = [[\"ida\", \"gauss\"], [\"ida\", \"gauss\"]]\n");
  EXPECT_THAT(twice, HasSubstr("'integrators' sweeps ida and gauss twice"));
  EXPECT_THAT(twice, Not(HasSubstr("two of the models")));
  write_file(folder_.path() / "more" / "one.toml", kPendulum);
  EXPECT_THAT(refusal("[[case]]\nmodels = [\"models/one.toml\", \"more/one.toml\"]\n"),
              HasSubstr("suite.toml:3:10: error: case: two of the models would be case 'one', one of them '"));
  EXPECT_THAT(refusal(""), HasSubstr("there is no case"));
  write_file(folder_.path() / "suite.toml", "format = 9\n[[case]]\nmodels = [\"models/one.toml\"]\n");
  EXPECT_THROW(read_suite(folder_.path() / "suite.toml"), InputError);
}

TEST_F(Suites, SweptValuesHaveAsManyDigitsInTheirNamesAsTellThemApart) {
  EXPECT_THAT(ids("[[case]]\nmodels = [\"models/one.toml\"]\nsweep.parameters = { arm = [0.2, 0.20000001, 3] }\n"),
              ElementsAre("one/arm=0.2", "one/arm=0.20000001", "one/arm=3"));
}

/// Finds one model that was moved away and takes the night of all the others with it.
TEST_F(Suites, ModelThatIsNotThereIsRefusedAsACaseOfItsOwn) {
  const Suite suite =
      read("[[case]]\nmodels = [\"models/one.toml\", \"models/gone.toml\"]\nparameters = { mass = 2 }\n");
  ASSERT_EQ(suite.cases.size(), 2U);
  EXPECT_EQ(suite.cases.at(0).id, "gone");
  const SolverMakers makers{cartesian::make_solver, relative::make_solver};
  const Result result = try_case(suite.cases.at(0), folder_.path(), makers);
  EXPECT_EQ(result.ending, Ending::bad_input);
  EXPECT_THAT(result.words, HasSubstr("gone.toml: error: cannot read the file"));
}

TEST_F(Suites, ParametersCutsNeedsAndStartsReachTheModel) {
  const Suite suite = read(
      "[[case]]\nmodels = [\"models/one.toml\"]\nparameters = { mass = 2.5 }\ncut = [\"hinge\"]\n"
      "need = [{ joint = \"hinge\", same_run = 5, because = \"soft\" }]\n"
      "[case.sweep]\nstart = { seed = 4, count = 2, turn = 0.1, turn_speed = 0.3 }\n");
  const Model first = model_of(suite.cases.at(0));
  const Model second = model_of(suite.cases.at(1));
  EXPECT_DOUBLE_EQ(first.bodies.at(1).mass, 2.5);
  EXPECT_TRUE(first.joints.at(0).named_as_cut);
  EXPECT_EQ(first.needs.at(0).because, "soft");
  EXPECT_NE(first.joints.at(0).start.at(0).q(0), second.joints.at(0).start.at(0).q(0));
  EXPECT_NEAR(first.joints.at(0).start.at(0).q(0), 0.4, 0.1);
  EXPECT_NE(first.joints.at(0).start.at(0).u(0), 2.0);
  EXPECT_EQ(model_of(suite.cases.at(0)).joints.at(0).start.at(0).q(0), first.joints.at(0).start.at(0).q(0));
  EXPECT_THROW(model_of(read("[[case]]\nmodels = [\"models/one.toml\"]\ncut = [\"hing\"]\n").cases.at(0)), InputError);
}

TEST_F(Suites, WhatAModelCannotGiveIsRefusedAtTheCase) {
  const SolverMakers makers{cartesian::make_solver, relative::make_solver};
  const auto words_of = [&](const std::string& keys) {
    const Suite suite = read("[[case]]\nmodels = [\"models/one.toml\"]\n" + keys);
    const Result result = try_case(suite.cases.at(0), folder_.path(), makers);
    EXPECT_EQ(result.ending, Ending::bad_input);
    return result.words;
  };
  EXPECT_THAT(words_of("cut = [\"hing\"]\n"),
              AllOf(HasSubstr("suite.toml:2:1: error: "),
                    HasSubstr("one.toml: no joint is called 'hing', which the case cuts")));
  EXPECT_THAT(words_of("cartesian = \"erk\"\n"),
              AllOf(HasSubstr("suite.toml:2:1: error: "), HasSubstr("no integrator 'erk'; it has gauss, ida")));
  EXPECT_THAT(
      words_of("work = \"inverse\"\naccelerations = { \"hinge.turn_x\" = 2.5 }\n"),
      AllOf(HasSubstr("suite.toml:5:"), HasSubstr("turn_x of hinge, which "), HasSubstr("one.toml does not keep")));
}

TEST_F(Suites, DefinitionTellsWhatIsAskedAndOfWhichFile) {
  const std::string text = "[[case]]\nmodels = [\"models/one.toml\"]\nuntil = 0.3\n";
  const std::string before = definition_of(read(text).cases.at(0));
  EXPECT_EQ(definition_of(read(text).cases.at(0)), before);
  EXPECT_NE(definition_of(read(text + "rtol = 1e-9\n").cases.at(0)), before);
  write_file(folder_.path() / "models" / "one.toml", std::string(kPendulum) + "# heavier\n");
  EXPECT_NE(definition_of(read(text).cases.at(0)), before);
}

/// Finds a result that passes for this case's although an included part or its modes are others now.
TEST_F(Suites, DefinitionTellsWhatStandsInIncludedFilesAndModes) {
  const std::filesystem::path models = folder_.path() / "models";
  write_file(models / "one.toml", std::string(kPendulum) + "[[include]]\nfile = \"parts/arm.toml\"\n");
  write_file(models / "parts" / "arm.toml", "[[body]]\nname = \"arm\"\nmodes_file = \"arm.modes\"\n");
  write_file(models / "parts" / "arm.modes", "modes");
  const std::string text = "[[case]]\nmodels = [\"models/one.toml\"]\n";
  const std::string before = definition_of(read(text).cases.at(0));
  EXPECT_EQ(definition_of(read(text).cases.at(0)), before);
  write_file(models / "parts" / "arm.modes", "other modes");
  const std::string after = definition_of(read(text).cases.at(0));
  EXPECT_NE(after, before);
  write_file(models / "parts" / "arm.toml", "[[body]]\nname = \"arm\"\nmodes_file = \"arm.modes\"\n# other\n");
  EXPECT_NE(definition_of(read(text).cases.at(0)), after);
}

TEST(Patterns, MeanPartsOfNamesOrGlobs) {
  EXPECT_TRUE(is_meant("statics/car", "car"));
  EXPECT_TRUE(is_meant("statics/car", "statics/*"));
  EXPECT_FALSE(is_meant("statics/car", "car*"));
}

}  // namespace concord::compare::nightly
