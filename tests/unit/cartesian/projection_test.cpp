#include "cartesian/dynamics/projection.h"

#include <gtest/gtest.h>

#include "cartesian/rank/closing.h"
#include "two_bodies.h"

namespace concord::cartesian {
namespace {

using testing::Numbers;
using testing::TwoBodies;

TEST(Projection, ClosesPositionsAndVelocities) {
  TwoBodies rig(103, "cylindrical", 2, 0);
  Equations& equations = rig.equations;
  ASSERT_TRUE(close_machine(equations, 0.0, Hold::constraints, Modes::kept, rig.q, rig.Y).closed);
  const Solution& nearby = rig.dynamics.solve(Pivots::fresh);
  Numbers numbers(104);
  rig.q += numbers.matrix(static_cast<int>(rig.q.size()), 1, 1e-5);
  rig.Y += numbers.matrix(static_cast<int>(rig.Y.size()), 1, 1e-5);
  equations.update(0.0, rig.q, rig.Y);
  EXPECT_GT(equations.residual().norm(), 1e-6);
  rig.dynamics.project(nearby, 0.0, rig.q, rig.Y);
  equations.update(0.0, rig.q, rig.Y);
  EXPECT_LT(equations.residual().norm(), 1e-13);
  EXPECT_LT(equations.velocity_residual().norm(), 1e-13);
}

/// What reads the equations after a projection must find the state that they were updated to.
TEST(Projection, LeavesTheEquationsWhereTheyAre) {
  TwoBodies rig(105, "universal", 2, 1);
  ASSERT_TRUE(close_machine(rig.equations, 0.0, Hold::constraints, Modes::kept, rig.q, rig.Y).closed);
  Numbers numbers(106);
  rig.q += numbers.matrix(static_cast<int>(rig.q.size()), 1, 1e-5);
  const Solution& nearby = rig.dynamics.solve_at(0.0, rig.q, rig.Y, Pivots::fresh);
  const VecX residual = rig.equations.residual();
  const Vec3 gap = rig.equations.moving_constraints().joint(JointIndex(0)).gap;
  VecX gamma(residual.size());
  rig.equations.moving_constraints().write_gamma(0.0, gamma);
  rig.dynamics.project(nearby, 0.0, rig.q, rig.Y);
  VecX gamma_after(residual.size());
  rig.equations.moving_constraints().write_gamma(0.0, gamma_after);
  EXPECT_EQ(rig.equations.residual(), residual);
  EXPECT_EQ(rig.equations.moving_constraints().joint(JointIndex(0)).gap, gap);
  EXPECT_EQ(gamma_after, gamma);
}

/// A thread that has turned three times: a projection that counts from elsewhere moves it along by whole turns.
TEST(Projection, CountsTurnsAsTheEquationsDo) {
  Model model = testing::make_pair(107, *joints::find("cylindrical"), 0, 0);
  model.couplings.push_back({"thread", {{0, 0, 0, 1.0}, {0, 1, 0, 0.1}}, 0.0, {}});
  Equations equations(model);
  Dynamics dynamics(equations);
  Numbers numbers(108);
  VecX q;
  VecX Y;
  bool closed = false;
  for (int guess = 0; guess < 10 && !closed; ++guess) {  // a guess far off may end on the branch of turned axes
    q = numbers.matrix(equations.layout().n_q(), 1, 0.3);
    Y = numbers.matrix(equations.layout().n_Y(), 1, 1.5);
    equations.count_turns_from({Eigen::Vector2d(-0.6 * EIGEN_PI, 6.0 * EIGEN_PI)});
    closed = close_machine(equations, 0.0, Hold::constraints, Modes::kept, q, Y).closed;
  }
  ASSERT_TRUE(closed);
  const VecX before = q;
  dynamics.project(dynamics.solve_at(0.0, q, Y, Pivots::fresh), 0.0, q, Y);
  EXPECT_LT((q - before).norm(), 1e-12);
}

}  // namespace
}  // namespace concord::cartesian
