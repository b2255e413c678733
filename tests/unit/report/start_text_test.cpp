#include "compare/report/start_text.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "compare/states/other_assemblies.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kDegree = std::numbers::pi / 180.0;

/// Pendulums that all hang on the ground, the first hinge keeps 40 deg; the others are said to be at `guess`, and are
/// at `got` [deg].
struct Row {
  Row(int count, double guess, const std::vector<double>& got) : model(pendulum_model()) {
    FakePendulum solver(model, "cartesian");
    start = solver.assemble();
    for (int k = 1; k < count; ++k) {
      Joint hinge = model.joints.front();
      hinge.name = "B" + std::to_string(k);
      hinge.start.front().role_q = StartRole::guess;
      hinge.start.front().q(0) = guess * kDegree;
      model.joints.push_back(hinge);
      start.q.emplace_back(VecX::Constant(1, got.at(static_cast<std::size_t>(k) - 1) * kDegree));
    }
  }
  Model model;
  State start;
};

TEST(StartTextTest, TellsWhatMovedFromItsGuess) {
  const Row row(4, 30.0, {30.1, -75.0, 391.0});
  EXPECT_EQ(format_start(row.model, report_start(row.model, row.start), true),
            "| joint | coordinate | at the start | the model says |    moved |\n"
            "|-------|------------|-------------:|----------------|---------:|\n"
            "| A     | turn_z     |   40.107 deg | keep           |          |\n"
            "| B1    | turn_z     |     30.1 deg | guess 30 deg   |          |\n"
            "| B2    | turn_z     |      -75 deg | guess 30 deg   | -105 deg |\n"
            "| B3    | turn_z     |      391 deg | guess 30 deg   |    1 deg |\n");
}

/// Of more kept values than the machine has freedoms.
TEST(StartTextTest, AValueThatIsKeptNoFurtherThanItIsWrittenIsShownBesideWhatIsFound) {
  Row row(2, 30.0, {30.04});
  row.model.joints[1].start.front().role_q = StartRole::keep;
  row.model.joints[1].start.front().slack_q = VecX::Constant(1, 0.05 * kDegree);
  const StartReport start = report_start(row.model, row.start);
  EXPECT_THAT(format_start(row.model, start, true),
              HasSubstr("| A     | turn_z     |   40.107 deg | keep           |       |\n"
                        "| B1    | turn_z     |    30.04 deg | keep 30 deg    |       |\n"));
  EXPECT_NEAR(start_json(row.model, start)["coordinates"][1]["written"].get<double>(), 30.0 * kDegree, 1e-12);
  EXPECT_FALSE(start_json(row.model, start)["coordinates"][0].contains("written"));
}

TEST(StartTextTest, OfANightTheCoordinateThatDiffersMostIsTold) {
  Row row(3, 30.0, {30.0, -60.0});
  StartReport start = report_start(row.model, row.start);
  EXPECT_EQ(poses_line(row.model, start), "");
  row.start.q[2](0) = 100.0 * kDegree;
  add_other_pose(row.model, row.start, start);
  EXPECT_EQ(poses_line(row.model, start),
            "starts with turn_z of B2 at -60 deg; 1 other pose was found with the same kept coordinates: 100 deg");
}

TEST(StartTextTest, AWholeTurnThatASpringReadsIsAMove) {
  Row row(2, 30.0, {391.0});
  JointSpring spring;
  spring.law.stiffness = 3.0;
  row.model.joints[1].springs = {spring};
  EXPECT_THAT(format_start(row.model, report_start(row.model, row.start), true),
              HasSubstr("| guess 30 deg   | 361 deg |"));
}

TEST(StartTextTest, OfManyCoordinatesThoseThatMovedMostAreShown) {
  const Row row(12, 0.0, {0, 0, 0, 0, 0, 0, 0, 0, 20, 0, -15});
  const StartReport start = report_start(row.model, row.start);
  const std::string few = format_start(row.model, start, false);
  EXPECT_THAT(few, HasSubstr("| B9    | turn_z     |       20 deg | guess 0 deg    |  20 deg |\n"));
  EXPECT_THAT(few, HasSubstr("| B11   | turn_z     |      -15 deg | guess 0 deg    | -15 deg |\n"));
  EXPECT_THAT(few, Not(HasSubstr("| B10 ")));
  EXPECT_THAT(few, HasSubstr("and 4 coordinates more: --all names them\n"));
  EXPECT_EQ(start_json(row.model, start)["coordinates"].size(), 12U);
}

TEST(StartTextTest, AStartFromTheEquilibriumKeepsNothing) {
  Row row(2, 30.0, {30.0});
  row.model.run.from_equilibrium = true;
  row.start.q[0](0) += 0.2;
  const std::string text = format_start(row.model, report_start(row.model, row.start), true);
  EXPECT_THAT(text, HasSubstr("| guess 40.107 deg | 11.4592 deg |"));
}

TEST(StartTextTest, ABodyThatStandsElsewhereThanItsGuessIsNamed) {
  Row row(1, 0.0, {});
  BodyState& bob = row.start.bodies[1];
  row.model.bodies[1].pose_guess = Pose{bob.r + Vec3(0.0, 0.3, 0.4), rotation_of(bob.p)};
  EXPECT_THAT(format_start(row.model, report_start(row.model, row.start), true),
              HasSubstr("moved from the guessed pose: body bob by 0.5 m and 0 deg\n"));
}

TEST(StartTextTest, OtherPosesAreColumnsAndSaidToBeFound) {
  const Row row(3, 30.0, {30.0, -75.5225});
  StartReport start = report_start(row.model, row.start);
  State other = row.start;
  other.q[1](0) = 50.0 * kDegree;
  other.q[2](0) = 284.4775 * kDegree;  // the same a turn on
  add_other_pose(row.model, other, start);
  start.others.guesses = 19;
  start.others.found_by = "relative";
  start.others.accepted_by = "cartesian";
  const std::string text = format_start(row.model, start, false);
  EXPECT_THAT(text, HasSubstr("| B1    | turn_z     |       30 deg | guess 30 deg   |              |  50 deg |\n"));
  EXPECT_THAT(text, HasSubstr("| B2    | turn_z     | -75.5225 deg | guess 30 deg   | -105.522 deg |         |\n"));
  EXPECT_THAT(text, HasSubstr("found: 1 other pose with the same kept and driven coordinates, from 19 other guesses by "
                              "relative; cartesian accepts it\n"));
  const auto said = start_json(row.model, start);
  EXPECT_NEAR(said["other_poses"][0][1].get<double>(), 50.0 * kDegree, 1e-12);
  EXPECT_EQ(said["coordinates"][0]["said"], "keep");
  start.others.values.clear();
  EXPECT_THAT(format_start(row.model, start, false), HasSubstr("found no other pose from 19 other guesses\n"));
  start.others.not_sought = true;
  EXPECT_THAT(format_start(row.model, start, false),
              HasSubstr("other poses of so large a machine were not sought: `concord info` seeks them\n"));
}

TEST(LoopsTest, AreTheWaysThatAJointCloses) {
  Model model = pendulum_model();
  model.bodies.resize(4, model.bodies[1]);
  const Joint hinge = model.joints.front();
  model.joints.clear();
  const auto join = [&](int parent, int child) {
    model.joints.push_back(hinge);
    model.joints.back().sides[0].body = parent;
    model.joints.back().sides[1].body = child;
  };
  join(2, 3);
  join(0, 1);
  EXPECT_TRUE(loops_of(model).empty());
  join(1, 2);
  join(0, 3);
  join(3, 1);
  EXPECT_THAT(loops_of(model), ElementsAre(ElementsAre(1, 2, 0, 3), ElementsAre(0, 2, 4)));
}

/// Two hinges between ground and bob, closed where the second one stands at plus or minus 0.5 rad; it goes to the side
/// of its guess.
class TwoWays : public FakePendulum {
 public:
  explicit TwoWays(const Model& model) : FakePendulum(model, "relative"), model_(model) {}
  State assemble() override {
    State state = FakePendulum::assemble();
    state.q.resize(1);
    state.q.emplace_back(VecX::Constant(1, model_.joints[1].start[0].q(0) < 0.0 ? -0.5 : 0.5));
    state.bodies[1].r.x() += state.q[1](0);
    return state;
  }

 private:
  Model model_;
};

TEST(OtherAssembliesTest, EachIsFoundOnceAndKeepsWhatIsKept) {
  Model model = pendulum_model();
  model.joints.push_back(model.joints.front());
  model.joints[1].start[0].role_q = StartRole::guess;
  model.joints[1].start[0].q(0) = 0.3;
  const auto make = [](const Model& guess) {
    EXPECT_EQ(guess.joints[0].start[0].q(0), 0.7);
    return std::make_unique<TwoWays>(guess);
  };
  const State start = TwoWays(model).assemble();
  const OtherAssemblies found = find_other_assemblies(model, start, make, [](const State&) { return true; });
  EXPECT_EQ(found.guesses, 19);
  ASSERT_EQ(found.states.size(), 1U);
  EXPECT_EQ(found.states[0].q[1](0), -0.5);
  EXPECT_TRUE(find_other_assemblies(model, start, make, [](const State&) { return false; }).states.empty());
}

}  // namespace
}  // namespace concord::compare
