#include "relative/states.h"

#include <gtest/gtest.h>

#include "machines.h"

namespace concord::relative {
namespace {

class StatesOfMachine : public ::testing::TestWithParam<bool> {
 protected:
  StatesOfMachine()
      : model_(GetParam() ? test::spatial_slider_crank(true) : test::tree_of_all_joints(true)),
        equations_(model_),
        states_(equations_) {
    start_ = Assembly(equations_).start();
    equations_.move(start_.t, start_.q, start_.u);
    state_ = states_.write(start_.t, {});
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
  EXPECT_LT((found.u - equations_.u()).norm(), 1e-12);
  EXPECT_LT((found.q - equations_.q()).norm(), 1e-13);
}

TEST_P(StatesOfMachine, NeedsNoHints) {
  State bare = state_;
  bare.q.clear();
  bare.u.clear();
  StateMisfit misfit;
  const Coordinates found = states_.read(bare, misfit);
  EXPECT_LT(misfit.largest, 1e-14);
  equations_.move(0.0, found.q, found.u);
  const State again = states_.write(0.0, state_);
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
  equations.move(0.0, start.q, start.u);
  States states(equations);
  State state = states.write(0.0, {});
  StateMisfit misfit;
  (void)states.read(state, misfit);
  EXPECT_LT(misfit.largest, 1e-14);
  state.t = 1e-6;
  (void)states.read(state, misfit);
  EXPECT_NEAR(misfit.largest, 2e-6, 1e-8);
  EXPECT_EQ(misfit.where, "joint 'A'");
}

}  // namespace
}  // namespace concord::relative
