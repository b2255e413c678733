#include "cartesian/dynamics/dynamics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/error.h"
#include "common/reading/model_file.h"
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

/// Two arms of one length on ground and a rod between them, all in one line but for an angle: the rows of the rod are
/// the less independent the smaller it is.
Model flat_four_bar() {
  return parse_model(R"toml(format = 1
gravity = [0.3, -9.8, 0]
[[body]]
name = "one"
mass = 1
inertia = [0.01, 0.01, 0.01]
[[body]]
name = "rod"
mass = 1
inertia = [0.01, 0.1, 0.1]
[[body]]
name = "two"
mass = 1
inertia = [0.01, 0.01, 0.01]
[[joint]]
name = "A"
type = "revolute"
parent = "ground"
child = "one"
[[joint]]
name = "B"
type = "revolute"
parent = { body = "one", point = [1, 0, 0] }
child = "rod"
[[joint]]
name = "C"
type = "spherical"
parent = { body = "rod", point = [2, 0, 0] }
child = { body = "two", point = [1, 0, 0] }
[[joint]]
name = "D"
type = "cylindrical"
parent = { body = "ground", point = [2, 0, 0] }
child = "two"
[run]
until = 1
)toml",
                     "flat_four_bar.toml");
}

/// A pose that magnifies round-off does not keep inertias from being eliminated in those after it.
TEST(Dynamics, JudgesTheEliminationAgainBehindABadPose) {
  const Model model = flat_four_bar();
  Equations equations(model);
  Dynamics dynamics(equations);
  const VecX Y = VecX::Zero(equations.layout().n_Y());
  const auto eliminates_at = [&](double angle) {
    VecX q = VecX::Zero(equations.layout().n_q());
    const auto place = [&](int body, const Vec3& r, double turn) {
      q.segment<3>(7 * body) = r;
      q(7 * body + 3) = std::cos(0.5 * turn);
      q(7 * body + 6) = std::sin(0.5 * turn);
    };
    place(0, Vec3::Zero(), angle);
    place(1, Vec3(std::cos(angle), std::sin(angle), 0.0), 0.0);
    place(2, Vec3(2.0, 0.0, 0.0), angle);
    (void)dynamics.solve_at(0.0, q, Y, Pivots::fresh);
    return dynamics.eliminates_inertias();
  };
  EXPECT_FALSE(eliminates_at(1e-7));
  EXPECT_TRUE(eliminates_at(1.0));
  EXPECT_FALSE(eliminates_at(1e-7));
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
