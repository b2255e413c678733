#include "cartesian/projection.h"

#include <gtest/gtest.h>

#include "cartesian/closing.h"
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
  const Vec3 gap = rig.equations.constraints().joint(0).gap;
  VecX gamma(residual.size());
  rig.equations.constraints().write_gamma(0.0, gamma);
  rig.dynamics.project(nearby, 0.0, rig.q, rig.Y);
  VecX gamma_after(residual.size());
  rig.equations.constraints().write_gamma(0.0, gamma_after);
  EXPECT_EQ(rig.equations.residual(), residual);
  EXPECT_EQ(rig.equations.constraints().joint(0).gap, gap);
  EXPECT_EQ(gamma_after, gamma);
}

}  // namespace
}  // namespace concord::cartesian
