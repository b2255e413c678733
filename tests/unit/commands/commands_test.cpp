#include "compare/program/commands.h"

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// The fake's pendulum as a file: frames and inertia are the reader's business, so a plain one will do.
const std::string kPendulum = pendulum_file("until = 0.2\nsamples = 200\n");

class CommandsTest : public ::testing::Test {
 protected:
  CommandsTest() { fs::create_directories(folder_); }
  ~CommandsTest() override { fs::remove_all(folder_); }

  fs::path file(const std::string& name, const std::string& text = kPendulum) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  int compare(const CompareCommand& command, bool progress = false) {
    return compare_models(command, makers_, {out_, err_, progress});
  }

  static std::unique_ptr<Solver> make(const Model& model, const char* name, bool is_broken = false) {
    auto solver = std::make_unique<FakePendulum>(model, name);
    solver->cannot_integrate = is_broken;
    return solver;
  }

  fs::path folder_ = fs::path(::testing::TempDir()) /
                     (std::string("concord_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
  std::ostringstream out_;
  std::ostringstream err_;
  SolverMakers makers_{[](const Model& model) { return make(model, "cartesian"); },
                       [](const Model& model) { return make(model, "relative"); }};
};

TEST_F(CommandsTest, OneModelGivesItsTableAndItsFiles) {
  CompareCommand command;
  command.models = {file("pendulum.toml")};
  command.out = folder_ / "results";
  command.json = folder_ / "verdict.json";
  EXPECT_EQ(compare(command), kAgree) << err_.str();
  EXPECT_THAT(out_.str(), HasSubstr("agree pendulum: 10 of 10 components judged"));
  EXPECT_THAT(err_.str(), HasSubstr("pendulum: wall time of the same run, cartesian 0.01 s"));
  for (const char* ending :
       {"table.txt", "cartesian.nc", "relative.nc", "cartesian.motion.csv", "relative.reactions.csv"}) {
    EXPECT_TRUE(fs::exists(folder_ / "results" / (std::string("pendulum.") + ending))) << ending;
  }
  EXPECT_TRUE(fs::exists(folder_ / "verdict.json"));
}

TEST_F(CommandsTest, OutputsThatCannotBeWrittenAreRefusedBeforeAnyWork) {
  CompareCommand command;
  command.models = {file("pendulum.toml")};
  const auto refused = [&](const fs::path& json, const fs::path& junit, const fs::path& out) {
    command.json = json;
    command.junit = junit;
    command.out = out;
    out_.str("");
    EXPECT_EQ(compare(command), kBadInput) << json << junit << out;
    EXPECT_EQ(out_.str(), "");
  };
  refused("/dev/null", "", "");
  refused("", "/dev/null", "");
  refused("", "", "/dev/null");
  refused("", folder_, "");
  refused(folder_ / "pendulum.toml", "", "");
  refused(folder_ / "not_there" / ".." / "pendulum.toml", "", "");
  refused(folder_ / "v", folder_ / "." / "v", "");
  for (const char* name : {"pendulum.result.json", "pendulum.relative.nc", "p.table.txt"}) {
    refused(folder_ / "results" / name, "", folder_ / "results");
  }
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}), 1);
}

TEST_F(CommandsTest, ResultsThatCannotBeReplacedAreRefusedBeforeTheRun) {
  fs::create_directories(folder_ / "results");
  fs::create_symlink("elsewhere", folder_ / "results" / "pendulum.relative.nc");
  CompareCommand command;
  command.models = {file("pendulum.toml")};
  command.out = folder_ / "results";
  EXPECT_EQ(compare(command), kBadInput);
  EXPECT_EQ(out_.str(), "");
  EXPECT_THAT(err_.str(), HasSubstr("pendulum.relative.nc: error: cannot be written: it is a symbolic link"));
}

TEST_F(CommandsTest, AVerdictOfAnEarlierRunDoesNotStandAfterABadModel) {
  CompareCommand command;
  command.models = {file("pendulum.toml")};
  command.json = folder_ / "verdict.json";
  command.junit = folder_ / "verdict.xml";
  ASSERT_EQ(compare(command), kAgree);
  ASSERT_TRUE(fs::exists(command.json));
  file("pendulum.toml", "format = 2\n");
  EXPECT_EQ(compare(command), kBadInput);
  EXPECT_FALSE(fs::exists(command.json));
  std::ostringstream junit;
  junit << std::ifstream(command.junit).rdbuf();
  EXPECT_THAT(junit.str(), HasSubstr("errors=\"1\""));
}

TEST_F(CommandsTest, TheExitCodeIsTheWorstAndTheSummaryNamesAll) {
  makers_.relative = [](const Model& model) { return make(model, "relative", model.name == "stuck"); };
  CompareCommand command;
  command.models = {file("good.toml"), file("stuck.toml"), file("bad.toml", "format = 1\n[[body]]\n")};
  EXPECT_EQ(compare(command), kCouldNotFinish);
  EXPECT_THAT(out_.str(), HasSubstr("| good  | 10 of 10 |"));
  EXPECT_THAT(out_.str(), HasSubstr("| stuck |  0 of 10 |"));
  EXPECT_THAT(out_.str(), HasSubstr("| could not finish |\n"));
  EXPECT_THAT(out_.str(), HasSubstr("| bad   |        - |"));
  EXPECT_THAT(err_.str(), HasSubstr("bad.toml:"));
}

TEST_F(CommandsTest, TwoModelsOfOneNameAreBadInput) {
  CompareCommand command;
  command.models = {file("one.toml"), file("one.toml")};
  EXPECT_EQ(compare(command), kBadInput);
  EXPECT_THAT(err_.str(), HasSubstr("a model called 'one' was compared already"));
}

TEST_F(CommandsTest, WithoutRunsTheLastLineSaysWhichChecksWereMade) {
  CompareCommand command;
  command.models = {file("stuck.toml")};
  command.options.integrates = false;
  makers_.relative = [](const Model& model) { return make(model, "relative", true); };
  EXPECT_EQ(compare(command), kAgree) << out_.str();
  EXPECT_THAT(out_.str(), ::testing::ContainsRegex("\nagree stuck: 10 of 10 components judged; passed: rank, same "
                                                   "state [0-9.]+, audit [0-9.]+\n$"));
  EXPECT_THAT(err_.str(), ::testing::Not(HasSubstr("wall time")));
}

TEST_F(CommandsTest, ProgressIsShownOnlyWhenAskedForAndWipedAtTheEnd) {
  CompareCommand command;
  command.models = {file("pendulum.toml")};
  compare(command);
  EXPECT_THAT(err_.str(), ::testing::Not(HasSubstr("\r")));
  compare(command, true);
  EXPECT_THAT(err_.str(), HasSubstr("\r\033[Kpendulum: 2 of 4, same run, cartesian "));
  EXPECT_THAT(err_.str(), HasSubstr("\r\033[Kpendulum: wall time"));
}

TEST_F(CommandsTest, RunWritesOneSolversResults) {
  RunCommand command;
  command.model = file("pendulum.toml");
  command.solver = "relative";
  command.out = folder_ / "results";
  EXPECT_EQ(run_model(command, makers_, {out_, err_}), kAgree);
  EXPECT_THAT(out_.str(), HasSubstr("pendulum: relative by rk4, 0.2 s, 201 samples, rtol 1e-11"));
  EXPECT_TRUE(fs::exists(folder_ / "results" / "pendulum.relative.nc"));
  EXPECT_FALSE(fs::exists(folder_ / "results" / "pendulum.cartesian.nc"));
}

TEST_F(CommandsTest, RunWithoutASolverIsByEachAlone) {
  RunCommand command;
  command.model = file("pendulum.toml");
  command.out = folder_ / "results";
  EXPECT_EQ(run_model(command, makers_, {out_, err_}), kAgree);
  EXPECT_THAT(out_.str(), HasSubstr("pendulum: cartesian by rk4, 0.2 s, 201 samples, rtol 1e-11"));
  EXPECT_THAT(out_.str(), HasSubstr("\n\npendulum: relative by rk4, 0.2 s, 201 samples, rtol 1e-11"));
  EXPECT_TRUE(fs::exists(folder_ / "results" / "pendulum.cartesian.nc"));
  EXPECT_TRUE(fs::exists(folder_ / "results" / "pendulum.relative.nc"));
  command.integrator = "rk4";
  EXPECT_EQ(run_model(command, makers_, {out_, err_}), kBadInput);
  EXPECT_THAT(err_.str(),
              HasSubstr("--integrator: error: is one solver's own: name that by --solver cartesian or relative"));
}

TEST_F(CommandsTest, AxesThatNoBodyHasAreBadInputBeforeAnyRun) {
  CompareCommand command;
  command.models = {file("pendulum.toml")};
  command.axes = "bbo";
  EXPECT_EQ(compare(command), kBadInput);
  EXPECT_EQ(out_.str(), "");
  EXPECT_THAT(err_.str(), HasSubstr("pendulum.toml: error: --axes: there is no body 'bbo': "));
  command.axes = "world";
  EXPECT_EQ(compare(command), kAgree);
  EXPECT_THAT(out_.str(), HasSubstr("wrenches in global axes, each at the point of its own side; "));
  RunCommand run;
  run.model = command.models[0];
  run.axes = "bbo";
  EXPECT_EQ(run_model(run, makers_, {out_, err_}), kBadInput);
}

TEST_F(CommandsTest, ARunMayStartFromTheEquilibrium) {
  RunCommand command;
  command.model = file("pendulum.toml", std::string(kPendulum) + "start = \"equilibrium\"\n");
  command.out = folder_ / "results";
  EXPECT_EQ(run_model(command, makers_, {out_, err_}), kAgree) << err_.str();
  EXPECT_THAT(out_.str(), HasSubstr("note: starts from the equilibrium, on which both agree to 1"));
  std::ifstream csv(folder_ / "results" / "pendulum.cartesian.motion.csv");
  std::string header;
  std::string first;
  std::getline(csv, header);
  std::getline(csv, first);
  // Hanging: the mass centre stands along gravity.
  EXPECT_NEAR(std::stod(first.substr(first.rfind(',') + 1)), std::atan2(-9.81, 0.3) - std::atan2(0.1, 0.2), 1e-12);
  command.model = file("other.toml", std::string(kPendulum) + "start = \"rest\"\n");
  EXPECT_EQ(run_model(command, makers_, {out_, err_}), kBadInput);
  EXPECT_THAT(err_.str(), HasSubstr("'start' of a run is \"given\" or \"equilibrium\", found \"rest\""));
}

TEST_F(CommandsTest, AReferenceAndJUnitStandBesideTheVerdict) {
  CompareCommand command;
  command.models = {file("pendulum.toml")};
  command.reference = file("measured.csv", "# error = 1 %\nt [s],hinge.child.F_x [N]\n0.1,1e6\n");
  command.junit = folder_ / "verdict.xml";
  EXPECT_EQ(compare(command), kDiffer);
  EXPECT_THAT(out_.str(), HasSubstr("| against measured.csv | "));
  std::ifstream xml(command.junit);
  std::string line;
  std::getline(xml, line);
  EXPECT_EQ(line, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>");
  command.models.push_back(file("second.toml"));
  EXPECT_EQ(compare(command), kBadInput);
  EXPECT_THAT(err_.str(), HasSubstr("a reference belongs to one model, but 2 are compared"));
}

TEST_F(CommandsTest, NoResultReplacesAnInput) {
  CompareCommand command;
  command.models = {file("pendulum.toml")};
  command.out = folder_;
  const std::string text = "# error = 1 %\nt [s],hinge.child.F_x [N]\n0.1,1e6\n";
  command.reference = file("pendulum.cartesian.reactions.csv", text);
  EXPECT_EQ(compare(command), kBadInput);
  EXPECT_THAT(err_.str(), HasSubstr("pendulum.cartesian.reactions.csv: error: cannot be written: it is an input"));
  std::ifstream kept(command.reference);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(kept), {}), text);
}

TEST_F(CommandsTest, ARunThatStopsIsExitThree) {
  makers_.cartesian = [](const Model& model) { return make(model, "cartesian", true); };
  RunCommand command;
  command.model = file("pendulum.toml");
  command.solver = "cartesian";
  EXPECT_EQ(run_model(command, makers_, {out_, err_}), kCouldNotFinish);
  EXPECT_EQ(err_.str(), "cartesian: step size too small at t = 0.1 s\n");
  command.solver = "";
  command.out = folder_ / "results";
  EXPECT_EQ(run_model(command, makers_, {out_, err_}), kCouldNotFinish);
  EXPECT_THAT(out_.str(), HasSubstr("pendulum: relative by rk4"));
  EXPECT_FALSE(fs::exists(command.out)) << "all or nothing";
}

TEST_F(CommandsTest, InfoAsksBothSolvers) {
  EXPECT_EQ(show_info(file("pendulum.toml"), makers_, {out_, err_}), kAgree);
  EXPECT_THAT(out_.str(), HasSubstr("cartesian: 5 constraints of rank 5"));
  EXPECT_THAT(out_.str(), HasSubstr("relative: 5 constraints of rank 5"));
  EXPECT_EQ(show_info(folder_ / "absent.toml", makers_, {out_, err_}), kBadInput);
}

}  // namespace
}  // namespace concord::compare
