#include "compare/invariance/invariance_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "compare/invariance/command.h"
#include "compare/invariance/report.h"
#include "compare/quantities/align.h"
#include "machines.h"

namespace concord::compare::invariance {
namespace {

using testing::HasSubstr;

/// A solver that spoils its evaluations in one way that depends on how the machine is described.
class SpoiltSolver : public Solver {
 public:
  using Spoil = std::function<void(const Model&, const State&, Evaluation&)>;
  SpoiltSolver(const Model& model, Spoil spoil)
      : model_(model), solver_(relative::make_solver(model)), spoil_(std::move(spoil)) {}

  [[nodiscard]] std::string_view name() const override { return solver_->name(); }
  [[nodiscard]] std::vector<std::string> integrators() const override { return solver_->integrators(); }
  State assemble() override { return solver_->assemble(); }
  std::optional<State> close(const State& guess) override { return solver_->close(guess); }
  Evaluation evaluate(const State& state) override {
    Evaluation evaluation = solver_->evaluate(state);
    spoil_(model_, state, evaluation);
    return evaluation;
  }
  RankReport rank(const State& state) override { return solver_->rank(state); }
  MatX tangent(const State& state) override { return solver_->tangent(state); }
  Trajectory integrate(const RunOptions& options, const Progress& progress) override {
    return solver_->integrate(options, progress);
  }
  [[nodiscard]] std::vector<std::string> cut_joints() const override { return solver_->cut_joints(); }

 private:
  Model model_;
  std::unique_ptr<Solver> solver_;
  Spoil spoil_;
};

SolverMakers spoilt(const SpoiltSolver::Spoil& spoil) {
  return {cartesian::make_solver, [spoil](const Model& model) { return std::make_unique<SpoiltSolver>(model, spoil); }};
}

/// Moves under which the relative solver differs.
std::vector<std::string> red_moves(const InvarianceChecks& checks) {
  std::vector<std::string> names;
  for (const MoveRow& row : checks.rows) {
    EXPECT_FALSE(row.who == Who::cartesian && row.outcome == Outcome::differ) << checks.moves[row.move].name;
    if (row.outcome == Outcome::differ && row.applies) names.push_back(checks.moves[row.move].name);
  }
  return names;
}

// Detects a checks that judges nothing, or calls round-off a difference.
TEST(InvarianceChecks, SoundSolversAgreeWithThemselves) {
  const Model model = shipped("slider_crank_spatial_flexible");
  const InvarianceChecks checks = check_invariance(model, both_solvers(), {});
  EXPECT_EQ(checks.outcome, Outcome::agree) << format_checks(model, checks);
  EXPECT_EQ(checks.rows.size(), 20U);
  for (const MoveRow& row : checks.rows) EXPECT_EQ(row.judged > 50, row.applies) << checks.moves[row.move].name;
}

// Detects a checks that takes the round-off of a description's numbers for a difference: at map coordinates the weld
// that joins the two parts of a body carries forces at levers of 5000 km, and on a shaft nothing but round-off acts
// across its axis in one description, and exactly nothing in the other.
TEST(InvarianceChecks, RoundOffOfTheDescriptionIsNoDifference) {
  const char* const at_map_coordinates = R"(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "p"
mass = 1.2
inertia = [0.01, 0.02, 0.03]
center_of_mass = [0, 0, 0]
[[joint]]
name = "H"
type = "revolute"
parent = { body = "ground", point = [500000.0, 5000000.0, 100.0], x = [1, 0, 0], z = [0, 1, 0] }
child = { body = "p", point = [-0.3, 0, 0], x = [1, 0, 0], z = [0, 1, 0] }
start = { turn_z = { keep = 0.0, keep_speed = 1.0 } }
[run]
until = 0.4
)";
  const char* const shaft = R"(format = 1
[[body]]
name = "u"
beam = { length = 0.5, section = { width_y = 0.02, width_z = 0.012 }, youngs_modulus = 7e10, density = 2700, support = "cantilever", modes = { torsion = [1, 2] }, elements = 10, damping_ratio = 0.01, poissons_ratio = 0.3 }
[[body]]
name = "d"
mass = 2.0
inertia = [0.01, 0.01, 0.01]
center_of_mass = [0, 0, 0]
[[joint]]
name = "A"
type = "revolute"
parent = { body = "ground", point = [0, 0, 0], x = [0, 1, 0], z = [1, 0, 0] }
child = { body = "u", node = "first", x = [0, 1, 0], z = [1, 0, 0] }
drive = { turn_z = { law = "constant_speed", speed = 20.0 } }
[[joint]]
name = "D"
type = "weld"
parent = { body = "u", node = "last", x = [1, 0, 0], z = [0, 0, 1] }
child = { body = "d", point = [0, 0, 0], x = [1, 0, 0], z = [0, 0, 1] }
[run]
until = 0.2
)";
  for (const char* const text : {at_map_coordinates, shaft}) {
    const Model model = parse_model(text, "machine.toml");
    const InvarianceChecks checks = check_invariance(model, both_solvers(), {});
    EXPECT_EQ(checks.outcome, Outcome::agree) << format_checks(model, checks);
  }
}

// Detects moves that are no moves: a mistake of one kind must show under the move that changes what it depends on, and
// under no other.
TEST(InvarianceChecks, EachMistakeShowsUnderItsMove) {
  const Model model = shipped("double_pendulum_3d");
  const auto red_with = [&](const SpoiltSolver::Spoil& spoil) {
    return red_moves(check_invariance(model, spoilt(spoil), {}));
  };
  const auto reversed = [](const Model& told, const State&, Evaluation& evaluation) {
    for (std::size_t k = 0; k < told.joints.size(); ++k) {
      if (told.joints[k].on(Side::child).body != kGround) continue;
      std::swap(evaluation.joints[k].reaction[0], evaluation.joints[k].reaction[1]);
    }
  };
  EXPECT_THAT(red_with(reversed), testing::ElementsAre("sides"));
  const auto gravity_along_an_axis = [](const Model& told, const State&, Evaluation& evaluation) {
    if (std::abs(told.gravity.normalized().cwiseAbs().maxCoeff() - 1.0) < 1e-9) return;
    evaluation.joints[0].reaction[0].in_global.force *= 1.001;
  };
  EXPECT_THAT(red_with(gravity_along_an_axis), testing::ElementsAre("world"));
  const auto units = [](const Model& told, const State&, Evaluation& evaluation) {
    if (told.gravity.norm() > 100.0) evaluation.joints[1].total[1].in_C.torque *= 1.0 + 1e-9;
  };
  EXPECT_THAT(red_with(units), testing::ElementsAre("units"));
  const std::string first_joint = model.joints[0].name;
  const auto order = [first_joint](const Model& told, const State&, Evaluation& evaluation) {
    if (told.joints[0].name != first_joint) evaluation.bodies[1].omegadot *= 1.0 + 1e-8;
  };
  EXPECT_THAT(red_with(order), testing::ElementsAre("order"));
  const auto welds = [](const Model& told, const State&, Evaluation& evaluation) {
    if (told.joints.size() > 2) evaluation.joints[0].total[1].in_C.force *= 1.0 + 1e-8;
  };
  EXPECT_THAT(red_with(welds), testing::ElementsAre("welds", "split"));
}

// Detects a description that a solver refuses and that passes for agreement.
TEST(InvarianceChecks, ARefusedDescriptionIsADifference) {
  const Model model = shipped("double_pendulum_3d");
  const SolverMakers makers{cartesian::make_solver, [](const Model& told) {
                              if (told.joints.size() > 2)
                                throw InputError({told.file, 0, 0}, "welds are not my business");
                              return relative::make_solver(told);
                            }};
  const InvarianceChecks checks = check_invariance(model, makers, {});
  EXPECT_EQ(checks.outcome, Outcome::differ);
  EXPECT_THAT(red_moves(checks), testing::ElementsAre("welds", "split"));
  EXPECT_THAT(format_checks(model, checks), HasSubstr("welds are not my business"));
}

// Detects an answer that changes from run to run.
TEST(InvarianceChecks, SaysTheSameTwice) {
  const Model model = shipped("planetary_differential");
  const std::string first = format_checks(model, check_invariance(model, both_solvers(), {}));
  EXPECT_EQ(first, format_checks(model, check_invariance(model, both_solvers(), {})));
}

class InvarianceCommandTest : public testing::Test {
 protected:
  int run(const InvarianceCommand& command) {
    out_.str("");
    err_.str("");
    return try_invariance(command, both_solvers(), {out_, err_, false});
  }
  static std::filesystem::path file(const std::string& name) {
    return std::string(CONCORD_DATA) + "/models/" + name + ".toml";
  }

  std::ostringstream out_;
  std::ostringstream err_;
};

// Detects exit codes that do not tell, and a model that ends the whole command.
TEST_F(InvarianceCommandTest, EndsWithTheWorstCode) {
  InvarianceCommand command;
  command.models = {file("compound_pendulum")};
  EXPECT_EQ(run(command), 0) << out_.str();
  EXPECT_THAT(out_.str(), HasSubstr("agree compound_pendulum"));
  command.models = {"no_such_file.toml", file("compound_pendulum")};
  EXPECT_EQ(run(command), 2);
  EXPECT_THAT(out_.str(), HasSubstr("agree compound_pendulum"));
  command.models = {file("compound_pendulum")};
  command.options.moves = {"cut"};
  EXPECT_EQ(run(command), 3);
  EXPECT_THAT(out_.str(), HasSubstr("none of the moves applies"));
}

// Detects keys of the JSON that other programs read and that are gone.
TEST_F(InvarianceCommandTest, WritesWhatItFound) {
  InvarianceCommand command;
  command.models = {file("slider_crank_rigid")};
  command.options.moves = {"cut", "modes"};
  command.json = std::filesystem::path(testing::TempDir()) / "invariance_test.json";
  ASSERT_EQ(run(command), 0) << out_.str();
  std::ifstream stream(command.json);
  const nlohmann::json found = nlohmann::json::parse(stream);
  EXPECT_EQ(found["format"], 1);
  EXPECT_EQ(found["kind"], "concord invariance");
  EXPECT_EQ(found["verdict"], "agree");
  ASSERT_EQ(found["moves"].size(), 2U);
  EXPECT_EQ(found["moves"][0]["descriptions"], 4);
  EXPECT_EQ(found["moves"][0]["solvers"][0]["applies"], false);
  EXPECT_GE(found["moves"][0]["solvers"][1]["digits"], 10.0);
  EXPECT_EQ(found["moves"][1]["why_not"], "no body is flexible");
  std::filesystem::remove(command.json);
}

}  // namespace
}  // namespace concord::compare::invariance
