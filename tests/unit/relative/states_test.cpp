#include "relative/start/states.h"

#include <gtest/gtest.h>

#include <numbers>

#include "common/joints/screw.h"
#include "machines.h"
#include "relative/solver.h"

namespace concord::relative {
namespace {

class StatesOfMachine : public ::testing::TestWithParam<bool> {
 protected:
  StatesOfMachine()
      : model_(GetParam() ? test::spatial_slider_crank(true) : test::tree_of_all_joints(true)),
        equations_(model_),
        states_(equations_) {
    start_ = Assembly(equations_).start();
    state_ = states_.write(equations_.move(start_.t, start_.q, start_.u), {});
  }

  double misfit(const State& state) {
    StateMisfit found;
    (void)states_.read(state, found);
    return found.largest;
  }

  Model model_;
  Equations equations_;
  States states_;
  Coordinates start_;
  State state_;
};

TEST_P(StatesOfMachine, ReadsBackWhatItWrote) {
  StateMisfit misfit;
  const Coordinates found = states_.read(state_, misfit);
  EXPECT_LT(misfit.largest, 1e-14);
  EXPECT_LT((found.u - equations_.motion().u()).norm(), 1e-12);
  EXPECT_LT((found.q - equations_.motion().q()).norm(), 1e-13);
}

TEST_P(StatesOfMachine, NeedsNoHints) {
  State bare = state_;
  bare.q.clear();
  bare.u.clear();
  StateMisfit misfit;
  const Coordinates found = states_.read(bare, misfit);
  EXPECT_LT(misfit.largest, 1e-14);
  const State again = states_.write(equations_.move(0.0, found.q, found.u), state_);
  for (std::size_t i = 1; i < model_.bodies.size(); ++i) {
    EXPECT_LT((again.bodies[i].r - state_.bodies[i].r).norm(), 1e-13);
    EXPECT_LT((again.bodies[i].p - state_.bodies[i].p).norm(), 1e-13);
    EXPECT_LT((again.bodies[i].v - state_.bodies[i].v).norm(), 1e-12);
    EXPECT_LT((again.bodies[i].omega - state_.bodies[i].omega).norm(), 1e-12);
  }
}

TEST_P(StatesOfMachine, SeesEveryKindOfMisfit) {
  for (std::size_t i = 1; i < model_.bodies.size(); ++i) {
    if (model_.bodies[i].name == "body 6") continue;  // its free joint takes up anything
    State moved = state_;
    moved.bodies[i].r += 1e-9 * Vec3(1, 2, 3);
    EXPECT_GT(misfit(moved), 1e-11) << model_.bodies[i].name;
    State faster = state_;
    faster.bodies[i].v += 1e-8 * Vec3(1, 2, 3);
    EXPECT_GT(misfit(faster), 1e-11) << model_.bodies[i].name;
  }
  Vec4& p = state_.bodies[1].p;
  const State before = state_;
  p += 1e-9 * Vec4(-p(1), p(0), -p(3), p(2));
  EXPECT_GT(misfit(state_), 1e-10);
  state_ = before;
  p *= 1.0 + 1e-9;
  EXPECT_GT(misfit(state_), 1e-10);
  state_ = before;
  state_.bodies[1].omega += 1e-8 * Vec3(3, 1, 2);
  EXPECT_GT(misfit(state_), 1e-10);
}

TEST_P(StatesOfMachine, RefusesAStateOfAnotherShape) {
  State small = state_;
  small.bodies.pop_back();
  StateMisfit misfit;
  EXPECT_THROW((void)states_.read(small, misfit), SolverError);
  State stiff = state_;
  for (BodyState& body : stiff.bodies) body.a.resize(0);
  EXPECT_THROW((void)states_.read(stiff, misfit), SolverError);
}

TEST_P(StatesOfMachine, RefusesWhatIsNoNumber) {
  for (std::size_t i = 1; i < state_.bodies.size(); ++i) {
    State state = state_;
    state.bodies[i].omega.y() = std::nan("");
    StateMisfit misfit;
    EXPECT_THROW((void)states_.read(state, misfit), SolverError) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Machines, StatesOfMachine, ::testing::Bool(),
                         [](const auto& tested) { return tested.param ? "loop" : "tree"; });

TEST(States, MeasureDrivenCoordinatesAgainstTheirLaws) {
  Model model = test::spatial_slider_crank(false);
  test::release(model.joints[0]);
  model.joints[0].drivers.push_back({0, ConstantSpeed{model.joints[0].start[0].q(0), 2.0}});
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  const Motion& motion = equations.move(0.0, start.q, start.u);
  States states(equations);
  State state = states.write(motion, {});
  StateMisfit misfit;
  (void)states.read(state, misfit);
  EXPECT_LT(misfit.largest, 1e-14);
  state.t = 1e-6;
  (void)states.read(state, misfit);
  EXPECT_NEAR(misfit.largest, 2e-6, 1e-8);
  EXPECT_EQ(misfit.where, "joint 'A'");
}

TEST_P(StatesOfMachine, ReadsWhatIsOpenOnTheBranchesWhereItWas) {
  State open = state_;
  for (std::size_t i = 1; i < open.bodies.size(); ++i) open.bodies[i].r += 1e-4 * Vec3(1.0, -0.7, 0.4) / double(i);
  const Coordinates beside = states_.read_beside(open);
  EXPECT_GT((beside.q - start_.q).norm(), 1e-6);
  EXPECT_LT((beside.q - start_.q).norm(), 0.05);
  StateMisfit misfit;
  EXPECT_LT((beside.q - states_.read(open, misfit).q).norm(), 1e-9);
  EXPECT_GT(misfit.largest, 1e-6);
}

/// The elevation of a rod on two turns has two names; the state's coordinates choose.
TEST(States, KeepTheNameOfALinkThatTheyCameWith) {
  Model model = test::pair(*test::type_named("distance"), 2);
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  const Motion& motion = equations.move(0.0, start.q, start.u);
  States states(equations);
  State state = states.write(motion, {});
  VecX& q = state.q[2];
  q(0) += std::numbers::pi;
  q(1) = std::numbers::pi - q(1);
  StateMisfit misfit;
  const Coordinates found = states.read(state, misfit);
  EXPECT_LT((found.q.segment(equations.topology().joints[2].first_q, 2) - q.head<2>()).norm(), 1e-13);
  EXPECT_LT(misfit.largest, 1e-13);
  EXPECT_FALSE(misfit.joint_off_branch);
}

/// A nut many turns up its thread: from the turn that the state says, from none at all, and from a wrong one.
TEST(States, CountTheTurnsOfAThread) {
  Model model;
  model.file = "thread.toml";
  test::Numbers numbers(88);
  model.bodies = {test::ground(), test::rigid_body("nut", numbers)};
  const joints::JointType thread = joints::screw_of({0.0013});
  Joint joint = test::joint(model, "J", "revolute", 0, 1, numbers);
  joint.type = &thread;
  joint.start[0].q = VecX::Constant(1, 71.3);
  model.joints = {joint};
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  const Motion& motion = equations.move(0.0, start.q, start.u);
  States states(equations);
  const State state = states.write(motion, {});
  const auto turn_from = [&](std::vector<VecX> hints, std::optional<JointIndex>& off_branch) {
    State given = state;
    given.q = std::move(hints);
    StateMisfit misfit;
    const double left = states.read(given, misfit).q(0);
    const double found = left + 2.0 * std::numbers::pi * states.turns()(0);
    EXPECT_LT(misfit.largest, 1e-13);
    off_branch = misfit.joint_off_branch;
    return found;
  };
  std::optional<JointIndex> off_branch;
  EXPECT_NEAR(turn_from({VecX::Constant(1, 70.0)}, off_branch), 71.3, 1e-11);
  EXPECT_EQ(off_branch, std::nullopt);
  EXPECT_NEAR(turn_from({}, off_branch), 71.3, 1e-11);
  EXPECT_EQ(off_branch, std::nullopt);
  EXPECT_NEAR(turn_from({VecX::Constant(1, 40.0)}, off_branch), 71.3, 1e-11);
  EXPECT_EQ(off_branch, 0);
}

/// Far from closed, as a guess is, the turn of the thread is that of the coordinates.
TEST(States, StayOnTheTurnOfAGuess) {
  Model model;
  model.file = "thread.toml";
  test::Numbers numbers(89);
  model.bodies = {test::ground(), test::rigid_body("nut", numbers)};
  const joints::JointType thread = joints::screw_of({0.0021});
  Joint joint = test::joint(model, "J", "revolute", 0, 1, numbers);
  joint.type = &thread;
  joint.start[0].q = VecX::Constant(1, 12.6);
  model.joints = {joint};
  const std::unique_ptr<Solver> solver = make_solver(model);
  State guess = solver->assemble();
  guess.bodies[1].r += Vec3(0.021, -0.013, 0.034);
  const std::optional<State> closed = solver->close(guess);
  ASSERT_TRUE(closed.has_value());
  EXPECT_NEAR(closed->q[0](0), 12.6, 0.5);
  guess.q[0](0) += 4.0 * std::numbers::pi;
  const std::optional<State> further = solver->close(guess);
  ASSERT_TRUE(further.has_value());
  EXPECT_NEAR(further->q[0](0), 12.6 + 4.0 * std::numbers::pi, 0.5);
}

/// Coordinates that count many turns more give the same machine, to the last digits: of tree and cut joints, of links,
/// driven or not.
TEST(States, SayTheSameOfAMachineAfterManyTurns) {
  constexpr double kTurns = 20000.0;
  for (const bool has_loop : {false, true}) {
    const Model model = has_loop ? test::spatial_slider_crank(false) : test::tree_of_all_joints(false);
    const auto solver = make_solver(model);
    const State once = solver->assemble();
    State often = once;
    int turned = 0;
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      const Mobilizer mobilizer(*model.joints[k].type);
      for (int c = 0; c < mobilizer.n_u(); ++c) {
        if (!mobilizer.is_turn(c)) continue;
        often.q[k](c) += 2.0 * std::numbers::pi * kTurns;
        ++turned;
      }
    }
    EXPECT_GT(turned, 2);
    const Evaluation first = solver->evaluate(once);
    const Evaluation then = solver->evaluate(often);
    double size = 0.0;
    for (const JointWrenches& joint : first.joints) size = std::max(size, joint.total[0].in_C.force.norm());
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      const Vec6 change = then.joints[k].total[0].in_C.vector() - first.joints[k].total[0].in_C.vector();
      EXPECT_LT(change.norm(), 1e-13 * size) << model.joints[k].name;
    }
    const std::optional<State> closed = solver->close(often);
    ASSERT_TRUE(closed);
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      EXPECT_LT((closed->q[k] - often.q[k]).norm(), 1e-10);
    }
    for (std::size_t i = 1; i < model.bodies.size(); ++i) {
      EXPECT_LT((closed->bodies[i].r - once.bodies[i].r).norm(), 1e-13);
      EXPECT_LT((closed->bodies[i].p - once.bodies[i].p).norm(), 1e-13);
    }
  }
}

/// Near the pose in which a rod has no bearing its bodies' round-off is multiplied in the bearing that is read: what a
/// coupling of it is off by is judged by that, and by no more.
TEST(States, JudgeACouplingByWhatItsCoordinatesCanBeRead) {
  constexpr double kFromSingular = 1e-3;
  constexpr double kBearing = 0.4;
  for (const double slip : {0.0, 1e-4}) {
    Model model = test::pair(*test::type_named("distance"), 0);
    std::vector<WordStart>& rod = model.joints[2].start;
    rod[0].q = VecX::Constant(1, kBearing);
    rod[0].u = VecX::Constant(1, slip);
    rod[1].q = VecX::Constant(1, 0.5 * std::numbers::pi - kFromSingular);
    rod[1].u = VecX::Constant(1, 2.7);
    Equations free(model);
    const Coordinates start = Assembly(free).start();
    const State state = States(free).write(free.move(start.t, start.q, start.u), {});
    Coupling coupling;
    coupling.name = "G";
    coupling.terms = {{2, 0, 0, 1.0}};
    coupling.offset = kBearing;
    model.couplings = {coupling};
    const Equations coupled(model);
    StateMisfit misfit;
    (void)States(coupled).read(state, misfit);
    if (slip == 0.0) {
      EXPECT_LT(misfit.largest, 1e-15);
    } else {
      EXPECT_GT(misfit.largest, 1e-12);
      EXPECT_EQ(misfit.where, "coupling 'G'");
    }
  }
}

}  // namespace
}  // namespace concord::relative
