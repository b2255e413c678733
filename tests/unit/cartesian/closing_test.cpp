#include "cartesian/rank/closing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "cartesian/solver.h"
#include "common/error.h"
#include "common/joints/catalogue.h"
#include "common/joints/screw.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

/// Every type between flexible bodies, from guesses that are off by a tenth.
TEST(Closing, ClosesEveryTypeToRoundOffAndLeavesTheModesAlone) {
  int closed = 0;
  for (const joints::JointType* type : joints::catalogue()) {
    SCOPED_TRACE(type->name);
    const Model model = testing::make_pair(141, *type, 2, 3);
    Equations equations(model);
    testing::Numbers numbers(142);
    VecX q = numbers.matrix(equations.layout().n_q(), 1, 0.1);
    VecX Y = numbers.matrix(equations.layout().n_Y(), 1);
    const std::vector<Pose> guesses = guess_poses(model);
    for (const BodyIndex i : equations.layout().moving_bodies()) {
      equations.layout().r(q, i) += guesses[i.value].r;
      equations.layout().p(q, i) += Vec4::Unit(0);
    }
    const VecX a = equations.layout().a(q, BodyIndex(2));
    const Closing closing = close_machine(equations, 0.0, Hold::constraints, Modes::kept, q, Y);
    if (!closing.closed) {  // random frames may lead Newton to the wrong branch, which is told
      EXPECT_EQ(closing.joints_left_open, std::vector<std::string>{type->name});
      continue;
    }
    ++closed;
    EXPECT_LT(closing.position_residual, 1e-14);
    EXPECT_EQ(VecX(equations.layout().a(q, BodyIndex(2))), a);
  }
  EXPECT_GE(closed, 5);
}

TEST(Closing, CountsKeptCoordinatesAgainstTheFreedom) {
  Model model = testing::make_pair(143, *joints::find("universal"), 0, 0);
  model.joints[0].sides[0] = {kGround, Vec3(0.1, 0.2, -0.3), rotation_about(Vec3(1, 1, 2).normalized(), 0.4),
                              Mat3X(3, 0), Mat3X(3, 0)};
  model.joints[0].sides[1].body = 1;
  model.bodies.pop_back();
  for (WordStart& start : model.joints[0].start) start.role_q = StartRole::keep;
  model.joints[0].start[0].role_u = StartRole::keep;
  Equations equations(model);
  VecX q = VecX::Zero(7);
  q(3) = 1.0;
  VecX Y = VecX::Zero(6);
  ASSERT_TRUE(close_machine(equations, 0.0, Hold::start, Modes::kept, q, Y).closed);
  const KeptCount kept = count_kept(equations, 0.0, q, Y);
  EXPECT_EQ(kept.coordinates, 2);
  EXPECT_EQ(kept.speeds, 1);
  EXPECT_EQ(kept.coordinate_freedom, 2);
  EXPECT_EQ(kept.speed_freedom, 2);
  EXPECT_EQ(kept.independent_coordinates, 2);
  EXPECT_EQ(kept.independent_speeds, 1);
}

/// A nut on a fine thread, driven or free to turn.
Model on_thread(bool is_driven) {
  testing::Numbers numbers(144);
  Model model;
  model.name = "nut";
  model.file = "nut.toml";
  model.bodies.resize(1);
  model.bodies.push_back(testing::make_body(numbers, "nut", 0));
  const auto type = std::make_shared<const joints::JointType>(joints::screw_of({0.0021}));
  model.joints.push_back(testing::make_joint(numbers, model, *type, kGround, 1));
  model.joints[0].own_type = type;
  model.joints[0].name = "thread";
  WordStart& start = model.joints[0].start[0];
  if (is_driven) {
    model.joints[0].drivers = {{0, ConstantSpeed{23.0, 1.0}, 0}};
  } else {
    start.role_q = start.role_u = StartRole::keep;
    start.q(0) = 23.0;
    start.u(0) = -0.4;
  }
  return model;
}

TEST(Closing, AThreadStaysOnTheTurnThatTheStateNames) {
  for (const bool is_driven : {true, false}) {
    const Model model = on_thread(is_driven);
    const auto solver = make_solver(model);
    State state = solver->assemble();
    EXPECT_NEAR(state.q[0](0), 23.0, 1e-11);
    EXPECT_NEAR(state.u[0](0), is_driven ? 1.0 : -0.4, 1e-12);
    const Vec3 axis = model.joints[0].on(Side::parent).C.col(2);
    state.bodies[1].r += 0.03 * axis + 0.01 * Vec3(1.0, 1.0, -1.0);  // two turns up
    const std::optional<State> closed = solver->close(state);
    ASSERT_TRUE(closed);
    EXPECT_NEAR(closed->q[0](0), 23.0, 1e-9);
    State other = *closed;
    other.q[0](0) += 2.0 * EIGEN_PI;
    try {
      (void)solver->evaluate(other);
      FAIL() << "a state on another turn was evaluated";
    } catch (const SolverError& error) {
      EXPECT_THAT(error.what(),
                  ::testing::HasSubstr("joint 'thread' stands at 23 rad, but its coordinate says 29.2832"));
    }
    EXPECT_NO_THROW((void)solver->evaluate(*closed));
  }
}

/// The rod of a distance joint beyond a right angle keeps what the start says.
TEST(Closing, AnArmBeyondUprightIsKept) {
  testing::Numbers numbers(145);
  Model model;
  model.name = "rod";
  model.file = "rod.toml";
  model.bodies.resize(1);
  model.bodies.push_back(testing::make_body(numbers, "load", 0));
  model.joints.push_back(testing::make_joint(numbers, model, *joints::find("distance"), kGround, 1));
  for (WordStart& word : model.joints[0].start) {
    if (word.q.size() == 0) continue;
    word.role_q = word.role_u = StartRole::keep;
  }
  model.joints[0].start[0].q(0) = 0.6;
  model.joints[0].start[0].u(0) = 0.5;
  model.joints[0].start[1].q(0) = 2.1;
  model.joints[0].start[1].u(0) = -1.5;
  const auto solver = make_solver(model);
  const State state = solver->assemble();
  EXPECT_NEAR(state.q[0](0), 0.6, 1e-14);
  EXPECT_NEAR(state.q[0](1), 2.1, 1e-14);
  EXPECT_NEAR(state.u[0](0), 0.5, 1e-14);
  EXPECT_NEAR(state.u[0](1), -1.5, 1e-14);
  RunOptions options;
  options.until = 0.1;
  options.samples = 4;
  const Trajectory trajectory = solver->integrate(options, {});
  EXPECT_NEAR(trajectory.samples[1].state.q[0](1), 2.1 - 1.5 * 0.025, 0.05);
}

}  // namespace
}  // namespace concord::cartesian
