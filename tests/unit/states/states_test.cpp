#include "compare/states/states.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

class StatesTest : public ::testing::Test {
 protected:
  Trajectory run(int samples) {
    return cartesian_.integrate({0.4, 1e-11, samples, ""}, [](double) {});
  }

  Model model_ = pendulum_model();
  FakePendulum cartesian_{model_, "cartesian"};
  FakePendulum relative_{model_, "relative"};
  std::array<Solver*, 2> solvers_{&cartesian_, &relative_};
};

TEST_F(StatesTest, TrajectoriesTakeTurnsFromTheStart) {
  const Trajectory one = run(300);
  const std::vector<OwnedState> states = run_states({&one, &one});
  ASSERT_EQ(states.size(), 301U);
  EXPECT_EQ(states[0].state.t, 0.0);
  EXPECT_EQ(states[0].owner, Who::cartesian);
  EXPECT_EQ(states[1].owner, Who::relative);
  EXPECT_DOUBLE_EQ(states[300].state.t, 0.4);
}

TEST_F(StatesTest, ShortRunsGiveBothStatesOfEachRow) {
  const Trajectory one = run(120);
  EXPECT_EQ(run_states({&one, &one}).size(), 242U);
}

TEST_F(StatesTest, AMissingTrajectoryLeavesItsTurns) {
  const Trajectory one = run(300);
  const std::vector<OwnedState> states = run_states({nullptr, &one});
  EXPECT_GE(states.size(), 150U);
  for (const OwnedState& state : states) EXPECT_EQ(state.owner, Who::relative);
  EXPECT_TRUE(run_states({nullptr, nullptr}).empty());
}

TEST_F(StatesTest, TheSameSeedShakesTheSameWay) {
  const Trajectory one = run(10);
  const std::vector<OwnedState> states = run_states({&one, &one});
  StatePerturbation perturbation(model_, states, kSeed);
  StatePerturbation again(model_, states, kSeed);
  StatePerturbation other(model_, states, kSeed + 1);
  const State perturbed = perturbation.perturb(states[3].state, 1.0);
  EXPECT_EQ((perturbed.bodies[1].r - again.perturb(states[3].state, 1.0).bodies[1].r).norm(), 0.0);
  EXPECT_GT((perturbed.bodies[1].r - other.perturb(states[3].state, 1.0).bodies[1].r).norm(), 1e-6);
  EXPECT_NEAR(perturbed.bodies[1].p.norm(), 1.0, 1e-15);
  EXPECT_GT((perturbed.bodies[1].omega - states[3].state.bodies[1].omega).norm(), 1e-3);
  EXPECT_EQ(perturbed.t, states[3].state.t);
}

TEST_F(StatesTest, AMachineAtRestIsShakenByItsOwnTime) {
  Trajectory one = run(10);
  for (Sample& sample : one.samples) {
    sample.state.bodies[1].v.setZero();
    sample.state.bodies[1].omega.setZero();
  }
  const std::vector<OwnedState> states = run_states({&one, &one});
  const Vec3 omega = StatePerturbation(model_, states, kSeed).perturb(states[0].state, 1.0).bodies[1].omega;
  model_.gravity *= 0x1p-40;  // the same machine with seconds 2^20 times shorter
  model_.run.until *= 0x1p20;
  const Vec3 slow = StatePerturbation(model_, states, kSeed).perturb(states[0].state, 1.0).bodies[1].omega;
  EXPECT_GT(omega.norm(), 0.0);
  EXPECT_EQ((slow - 0x1p-20 * omega).norm(), 0.0);
}

TEST_F(StatesTest, ModesAreDrawnWithinTheirRangeEvenIfTheRunNeverMovesThem) {
  ModalData modal;
  modal.stiffness = modal.damping = MatX::Identity(2, 2);
  modal.G = MatX::Identity(10, 10);
  modal.mass_points = {{1.0, Vec3::Zero(), Mat3X::Constant(3, 2, 2.0)}};
  model_.bodies[1].modal = modal;
  Trajectory one = run(10);
  for (Sample& sample : one.samples) {
    sample.state.bodies[1].a = sample.state.bodies[1].adot = VecX::Zero(2);
    sample.state.bodies[1].a(0) = 0.01 * sample.state.t;
  }
  const std::vector<OwnedState> states = run_states({&one, &one});
  StatePerturbation perturbation(model_, states, kSeed);
  const State perturbed = perturbation.perturb(states[0].state, 1.0);
  EXPECT_NE(perturbed.bodies[1].a(0), 0.0);
  EXPECT_LE(std::abs(perturbed.bodies[1].a(0)), 0.004);
  EXPECT_NE(perturbed.bodies[1].a(1), 0.0);
  EXPECT_LE(std::abs(perturbed.bodies[1].a(1)), 1e-4);
  EXPECT_NE(perturbed.bodies[1].adot(1), 0.0);
}

TEST_F(StatesTest, RandomStatesAreClosedInTurnAndEvaluatedByBoth) {
  const Trajectory one = run(300);
  const std::vector<OwnedState> states = run_states({&one, &one});
  const SharedStates random = share_random(model_, solvers_, states, kSeed);
  ASSERT_EQ(random.states.size(), static_cast<std::size_t>(kRandomStates));
  EXPECT_TRUE(random.failures.empty() && random.refusals.empty());
  for (const SharedState& shared : random.states) {
    const Vec3 gap = joint_point(model_, shared.state, model_.joints[0], Side::child) -
                     joint_point(model_, shared.state, model_.joints[0], Side::parent);
    EXPECT_LT(gap.norm(), 1e-14);
    EXPECT_EQ(shared.evaluations[0].joints.size(), 1U);
    EXPECT_EQ(shared.evaluations[1].joints.size(), 1U);
  }
}

/// Where the machine bears small displacements alone, each search goes on from what the last one found.
TEST_F(StatesTest, ANeighbourIsSoughtFromALittleFartherThanTheLastWasFound) {
  constexpr double kBears = 0.01;  // of the largest displacement of an angular velocity
  const Trajectory one = run(300);
  double turning = 0.0;
  for (const Sample& sample : one.samples) turning = std::max(turning, sample.state.bodies[1].omega.norm());
  int refused = 0;
  const auto bears_little = [&](const State& state, Evaluation&) {
    for (const Sample& sample : one.samples) {
      if (sample.state.t != state.t) continue;
      if ((sample.state.bodies[1].omega - state.bodies[1].omega).norm() <= kBears * turning) return;
    }
    ++refused;
    throw SolverError("too far");
  };
  cartesian_.spoil = relative_.spoil = bears_little;
  const SharedStates random = share_random(model_, solvers_, run_states({&one, &one}), kSeed);
  EXPECT_EQ(random.states.size(), static_cast<std::size_t>(kRandomStates));
  EXPECT_GT(refused, 0);
  EXPECT_LT(refused, kRandomStates) << "one shrink serves more than one state";
}

/// The other solver closes in its turn, and what it closed is refused: a difference.
TEST_F(StatesTest, ASolverThatFindsNoStateRefusesThoseOfTheOther) {
  const Trajectory one = run(300);
  relative_.spoil = [](const State&, Evaluation&) { throw SolverError("relative: wrong branch"); };
  const SharedStates random = share_random(model_, solvers_, run_states({&one, &one}), kSeed);
  EXPECT_EQ(random.refusals.size(), static_cast<std::size_t>(kRandomStates));
  EXPECT_EQ(random.left_open, 0);
  EXPECT_TRUE(random.states.empty());
}

TEST_F(StatesTest, StatesThatNeitherSolverClosesAreCounted) {
  const Trajectory one = run(300);
  for (FakePendulum* solver : {&cartesian_, &relative_}) {
    solver->spoil = [&one](const State& state, Evaluation&) {
      if (state.t > one.samples[150].state.t) throw SolverError("no state here");
    };
  }
  const SharedStates some = share_random(model_, solvers_, run_states({&one, &one}), kSeed);
  EXPECT_GT(some.left_open, kRandomStates / 3);
  EXPECT_EQ(some.states.size() + static_cast<std::size_t>(some.left_open), static_cast<std::size_t>(kRandomStates));
  EXPECT_TRUE(some.failures.empty());
  for (FakePendulum* solver : {&cartesian_, &relative_}) {
    solver->spoil = [](const State&, Evaluation&) { throw SolverError("no state anywhere"); };
  }
  const SharedStates none = share_random(model_, solvers_, run_states({&one, &one}), kSeed);
  EXPECT_EQ(none.left_open, kRandomStates);
  EXPECT_EQ(none.failures.size(), 1U);
  EXPECT_EQ(share_random(model_, solvers_, run_states({&one, &one}), kSeed, 3).failures.size(), 1U)
      << "few, none found";
}

}  // namespace
}  // namespace concord::compare
