#include "cartesian/equations.h"

#include <gtest/gtest.h>

#include "cartesian/closing.h"
#include "common/error.h"
#include "common/joints/catalogue.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

using testing::Numbers;

struct TwoBodies {
  Model model;
  Equations equations;
  VecX q;
  VecX Y;

  TwoBodies(unsigned seed, const std::string& type, int m_parent, int m_child)
      : model(testing::make_pair(seed, *joints::find(type), m_parent, m_child)), equations(model) {
    Numbers numbers(seed);
    q = numbers.matrix(equations.layout().n_q(), 1, 0.4);
    equations.layout().normalize(q);
    Y = numbers.matrix(equations.layout().n_Y(), 1, 1.5);
  }
};

/// The solution put back into the dense equations of motion, for two flexible bodies on a universal joint.
TEST(Equations, AccelerationsAndMultipliersSatisfyTheAugmentedEquations) {
  TwoBodies rig(101, "universal", 2, 3);
  Equations& equations = rig.equations;
  equations.update(0.0, rig.q, rig.Y);
  for (const bool fresh : {true, false}) {
    equations.solve(fresh);
    VecX balance = VecX::Zero(rig.Y.size());
    equations.write_mass_times(equations.Ydot(), balance);
    equations.add_Phi_Y_transposed_times(equations.lambda(), balance);
    balance -= equations.forces();
    EXPECT_LT(balance.norm(), 1e-12 * equations.forces().norm());
    VecX gamma(equations.constraints().n_rows());
    equations.constraints().write_gamma(0.0, gamma);
    const JointEquations& joint = equations.constraints().joint(0);
    for (int row = 0; row < joint.n_rows; ++row) {
      double acceleration = 0.0;
      for (const Side side : {Side::parent, Side::child}) {
        const int body = rig.model.joints[0].on(side).body;
        acceleration += joint.Phi_Y_transposed[index(side)].col(row).dot(
            equations.Ydot().segment(equations.layout().first_Y(body), equations.layout().size_Y(body)));
      }
      EXPECT_NEAR(acceleration, gamma(row), 1e-12 * (1.0 + gamma.norm()));
    }
  }
}

TEST(Equations, ProjectionClosesPositionsAndVelocities) {
  TwoBodies rig(103, "cylindrical", 2, 0);
  Equations& equations = rig.equations;
  ASSERT_TRUE(close_machine(equations, 0.0, Hold::constraints, Modes::kept, rig.q, rig.Y).closed);
  equations.solve(true);
  Numbers numbers(104);
  rig.q += numbers.matrix(static_cast<int>(rig.q.size()), 1, 1e-5);
  rig.Y += numbers.matrix(static_cast<int>(rig.Y.size()), 1, 1e-5);
  equations.update(0.0, rig.q, rig.Y);
  EXPECT_GT(equations.residual().norm(), 1e-6);
  equations.project(0.0, rig.q, rig.Y);
  equations.update(0.0, rig.q, rig.Y);
  EXPECT_LT(equations.residual().norm(), 1e-13);
  EXPECT_LT(equations.velocity_residual().norm(), 1e-13);
}

TEST(Equations, TellASingularMatrixAndItsTime) {
  TwoBodies rig(105, "revolute", 0, 0);
  rig.model.bodies[1].mass = 0.0;
  rig.model.bodies[1].inertia_L.setZero();
  rig.model.joints.clear();
  Equations equations(rig.model);
  equations.update(0.25, rig.q, rig.Y);
  try {
    equations.solve(true);
    FAIL() << "a body without mass was solved for";
  } catch (const SingularPose& error) {
    EXPECT_STREQ(
        error.what(),
        "cartesian: at t = 0.25 s the equations of motion are singular: the machine is in a singular pose, or a "
        "body can move without inertia");
  }
}

}  // namespace
}  // namespace concord::cartesian
