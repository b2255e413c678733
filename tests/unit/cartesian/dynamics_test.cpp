#include "cartesian/dynamics/dynamics.h"

#include <gtest/gtest.h>

#include <vector>

#include "common/error.h"
#include "two_bodies.h"

namespace concord::cartesian {
namespace {

using testing::TwoBodies;

/// The solution put back into the dense equations of motion, for two flexible bodies on a universal joint.
TEST(Dynamics, AccelerationsAndMultipliersSatisfyTheAugmentedEquations) {
  TwoBodies rig(101, "universal", 2, 3);
  const Equations& equations = rig.equations;
  ByBody<MatX> M = make_mass_matrices(equations.layout());
  for (const Pivots pivots : {Pivots::fresh, Pivots::kept}) {
    const Solution& solution = rig.dynamics.solve_at(0.0, rig.q, rig.Y, pivots);
    VecX balance = VecX::Zero(rig.Y.size());
    equations.write_mass_matrices(M);
    write_mass_times(equations.layout(), M, solution.Ydot(), balance);
    rig.dynamics.add_Phi_Y_transposed_times(solution.lambda(), balance);
    balance -= equations.forces();
    EXPECT_LT(balance.norm(), 1e-12 * equations.forces().norm());
    VecX gamma(equations.constraints().n_rows());
    equations.moving_constraints().write_gamma(0.0, gamma);
    const JointEquations& joint = equations.moving_constraints().joint(JointIndex(0));
    for (int row = 0; row < joint.n_rows; ++row) {
      double acceleration = 0.0;
      for (const Side side : {Side::parent, Side::child}) {
        const BodyIndex body = body_of(rig.model.joints[0].on(side));
        acceleration += joint.Phi_Y_transposed[index(side)].col(row).dot(
            solution.Ydot().segment(equations.layout().first_Y(body), equations.layout().size_Y(body)));
      }
      EXPECT_NEAR(acceleration, gamma(row), 1e-12 * (1.0 + gamma.norm()));
    }
  }
}

/// From the last state's pivots, or by new ones where those are not good.
TEST(Dynamics, SolvesToRoundOffWhateverStateWasSolvedForBefore) {
  TwoBodies rig(103, "universal", 2, 0);
  testing::Numbers numbers(29);
  for (int k = 0; k < 20; ++k) {
    const VecX move = (k % 2 == 0 ? 1e-6 : 1.5) * numbers.matrix(static_cast<int>(rig.Y.size()), 1);
    rig.equations.layout().displace(move, rig.q);
    Dynamics anew(rig.equations);
    const VecX expected = anew.solve_at(0.0, rig.q, rig.Y, Pivots::fresh).Ydot();
    const VecX& found = rig.dynamics.solve_at(0.0, rig.q, rig.Y, Pivots::fresh).Ydot();
    EXPECT_LT((found - expected).norm(), 1e-14 * expected.norm()) << k;
  }
}

TEST(Dynamics, TellASingularMatrixAndItsTime) {
  TwoBodies rig(105, "revolute", 0, 0);
  rig.model.bodies[1].mass = 0.0;
  rig.model.bodies[1].inertia_L.setZero();
  rig.model.joints.clear();
  Equations equations(rig.model);
  Dynamics dynamics(equations);
  try {
    (void)dynamics.solve_at(0.25, rig.q, rig.Y, Pivots::fresh);
    FAIL() << "a body without mass was solved for";
  } catch (const SingularPose& error) {
    EXPECT_STREQ(
        error.what(),
        "cartesian: at t = 0.25 s the equations of motion are singular: the machine is in a singular pose, a body can "
        "move without inertia, or inertias lie too far apart for double precision");
  }
}

}  // namespace
}  // namespace concord::cartesian
