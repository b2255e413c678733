#include "relative/dynamics/acceleration_refinement.h"

#include <gtest/gtest.h>

#include "machines.h"
#include "relative/start/assembly.h"

namespace concord::relative {
namespace {

class AccelerationRefinementTest : public ::testing::TestWithParam<bool> {};

/// Forces that the equations of motion do not have are what is left of them, and are taken away.
TEST_P(AccelerationRefinementTest, TakesAwayWhatTheEquationsDoNotHave) {
  const Model model = test::tree_of_all_joints(GetParam());
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  const Evaluated& evaluated = equations.compute_accelerations(0.0, start.q, start.u);
  const VecX nothing = VecX::Zero(equations.topology().n_u);
  ArticulatedInertias tree(equations.kinematics(), equations.driven());
  TreeAccelerations accelerations(equations.kinematics(), tree);
  tree.compute(evaluated.inertias(), evaluated.applied_forces(), nothing);
  accelerations.solve(tree, nothing);
  const VecX before = accelerations.udot();
  for (const LinkIndex l : upward<LinkIndex>(tree.n_links())) {
    accelerations.add_force(l, VecX::Constant(tree.n_unknowns(l), 1e-3));
  }
  accelerations.solve_again(tree);
  ASSERT_GT((accelerations.udot() - before).norm(), 1e-5 * before.norm());
  Reactions reactions(equations.kinematics(), equations.closure());
  AccelerationRefinement refinement(equations.kinematics(), equations.closure(), tree);
  const VecX no_lambda = VecX::Zero(equations.closure().n_rows());
  reactions.compute(evaluated.inertias(), accelerations, evaluated.applied_forces(), no_lambda);
  refinement.refine(tree, reactions, evaluated.applied_forces(), no_lambda, accelerations);
  EXPECT_LT((accelerations.udot() - before).norm(), 1e-11 * before.norm());
}

INSTANTIATE_TEST_SUITE_P(Trees, AccelerationRefinementTest, ::testing::Bool(),
                         [](const auto& tested) { return tested.param ? "flexible" : "rigid"; });

}  // namespace
}  // namespace concord::relative
