#include "relative/run/integrated_variables.h"

#include <gtest/gtest.h>

#include <numbers>

#include "machines.h"
#include "relative/start/assembly.h"

namespace concord::relative {
namespace {

/// The driven crank follows its law, and the speeds of the cut joint the tree; the cut joint's coordinates, by which
/// turns are counted, are integrated.
TEST(IntegratedVariables, LeaveOutWhatFollows) {
  Model model = test::spatial_slider_crank(true);
  test::release(model.joints[0]);
  model.joints[0].drivers.push_back({0, Harmonic{model.joints[0].start[0].q(0), 0.3, 4.0, 0.0}});
  const Equations equations(model);
  const Topology& topology = equations.topology();
  const IntegratedVariables variables(equations);
  ASSERT_EQ(variables.n_q(), topology.n_q - 1);
  ASSERT_EQ(variables.size(), topology.n_q - 1 + topology.n_tree_u - 1 + 1);
  Coordinates given{0.0, VecX::LinSpaced(topology.n_q, 1.0, 2.0), VecX::LinSpaced(topology.n_u, -2.0, -1.0)};
  VecX y = VecX::Constant(variables.size(), 77.0);
  variables.pack(given.q, given.u, y);
  EXPECT_EQ(y(variables.work()), 77.0);
  Coordinates found{0.0, VecX::Zero(topology.n_q), VecX::Zero(topology.n_u)};
  variables.unpack(y, found);
  const int driven_q = topology.joints[0].first_q;
  const int driven_u = topology.joints[0].first_u;
  for (int c = 0; c < topology.n_q; ++c) EXPECT_EQ(found.q(c), c == driven_q ? 0.0 : given.q(c)) << c;
  for (int c = 0; c < topology.n_u; ++c) {
    EXPECT_EQ(found.u(c), c == driven_u || c >= topology.n_tree_u ? 0.0 : given.u(c)) << c;
  }
}

TEST(IntegratedVariables, TakeWholeTurnsOff) {
  const Model model = test::spatial_slider_crank(false);
  const Equations equations(model);
  const Topology& topology = equations.topology();
  const IntegratedVariables variables(equations);
  VecX turns = VecX::Zero(topology.n_q);
  turns(topology.joints[0].first_q) = 3.0;
  VecX y = VecX::Constant(variables.size(), 20.0);
  variables.take_off(turns, y);
  Coordinates found{0.0, VecX::Zero(topology.n_q), VecX::Zero(topology.n_u)};
  variables.unpack(y, found);
  EXPECT_NEAR(found.q(topology.joints[0].first_q), 20.0 - 6.0 * std::numbers::pi, 1e-14);
  EXPECT_EQ(found.q.sum() - found.q(topology.joints[0].first_q), 20.0 * (topology.n_q - 1));
}

/// Lengths by the machine's, speeds by its rate, and no size is zero.
TEST(IntegratedVariables, HaveSizesOfTheMachine) {
  const Model model = test::spatial_slider_crank(true);
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  const IntegratedVariables variables(equations);
  const VecX sizes = sizes_of(variables, equations, start);
  Coordinates found{0.0, VecX::Zero(equations.topology().n_q), VecX::Zero(equations.topology().n_u)};
  variables.unpack(sizes, found);
  EXPECT_GT(sizes.minCoeff(), 0.0);
  EXPECT_EQ(found.q(equations.topology().joints[0].first_q), 1.0);
  EXPECT_EQ(found.q(equations.topology().joints[3].first_q), equations.size().length());
  const double rate = found.u(equations.topology().joints[0].first_u);
  EXPECT_NEAR(found.u(equations.topology().joints[3].first_u), rate * equations.size().length(), 1e-13);
}

}  // namespace
}  // namespace concord::relative
