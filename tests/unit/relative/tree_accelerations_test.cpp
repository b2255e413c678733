#include "relative/dynamics/tree_accelerations.h"

#include <gtest/gtest.h>

#include "machines.h"
#include "relative/start/assembly.h"

namespace concord::relative {
namespace {

class AcceleratedTree : public ::testing::TestWithParam<bool> {
 protected:
  AcceleratedTree()
      : model_(test::tree_of_all_joints(GetParam())), equations_(model_), start_(Assembly(equations_).start()) {}

  Model model_;
  Equations equations_;
  Coordinates start_;
};

/// The state along constant accelerations, to second order.
TEST_P(AcceleratedTree, AccelerationsOfPointsAreRatesOfTheirVelocities) {
  const Evaluated& evaluated = equations_.compute_accelerations(0.0, start_.q, start_.u);
  const VecX udot = evaluated.udot();
  std::vector<Vec6> expected;
  for (const JointIndex k : upward<JointIndex>(model_.joints.size())) {
    for (const Side side : {Side::parent, Side::child}) expected.push_back(evaluated.accelerations().of_point(k, side));
  }
  const double h = 1e-5;
  const auto velocities_at = [&](double t) {
    VecX q = start_.q;
    const Topology& topology = equations_.topology();
    for (const Link& link : topology.links) {
      const Span& joint = topology.joints[link.joint];
      const VecX step =
          t * start_.u.segment(joint.first_u, joint.n_u) + 0.5 * t * t * udot.segment(joint.first_u, joint.n_u);
      equations_.kinematics().mobilizer(link.joint).advance(q.data() + joint.first_q, step.data());
      const Span& modes = topology.modes[link.body];
      q.segment(modes.first_q, modes.n_q) += t * start_.u.segment(modes.first_u, modes.n_u);
    }
    equations_.move(0.0, q, start_.u + t * udot);
    std::vector<Vec6> velocities;
    for (const JointIndex k : upward<JointIndex>(model_.joints.size())) {
      for (const Side side : {Side::parent, Side::child}) {
        const JointPoint& point = equations_.kinematics().point(k, side);
        velocities.push_back((Vec6() << point.v, point.omega).finished());
      }
    }
    return velocities;
  };
  const std::vector<Vec6> ahead = velocities_at(h);
  const std::vector<Vec6> behind = velocities_at(-h);
  for (std::size_t p = 0; p < expected.size(); ++p) {
    const Vec6 rate = (ahead[p] - behind[p]) / (2.0 * h);
    EXPECT_LT((expected[p] - rate).norm(), 1e-6 * (1.0 + rate.norm())) << model_.joints[p / 2].name;
  }
}

/// Forces add to the right sides, not to the accelerations that were: an opposite one restores these.
TEST_P(AcceleratedTree, OppositeForcesCancel) {
  const Evaluated& evaluated = equations_.compute_accelerations(0.0, start_.q, start_.u);
  const VecX before = evaluated.udot();
  ArticulatedInertias tree(equations_.kinematics(), equations_.driven());
  TreeAccelerations accelerations(equations_.kinematics(), tree);
  const VecX nothing = VecX::Zero(equations_.topology().n_u);
  tree.compute(evaluated.inertias(), evaluated.applied_forces(), nothing);
  accelerations.solve(tree, nothing);
  EXPECT_EQ(accelerations.udot(), before);
  for (const LinkIndex l : upward<LinkIndex>(tree.n_links())) {
    if (tree.n_unknowns(l) == 0) continue;  // welded: nothing can push it along
    const VecX force = VecX::Constant(tree.n_unknowns(l), 0.5);
    const VecX here = accelerations.udot();
    accelerations.add_force(l, force);
    EXPECT_EQ(accelerations.udot(), here);
    accelerations.solve_again(tree);
    EXPECT_GT((accelerations.udot() - before).norm(), 1e-3);
    accelerations.add_force(l, -force);
    accelerations.solve_again(tree);
    EXPECT_LT((accelerations.udot() - before).norm(), 1e-12 * before.norm());
  }
}

INSTANTIATE_TEST_SUITE_P(Trees, AcceleratedTree, ::testing::Bool(),
                         [](const auto& tested) { return tested.param ? "flexible" : "rigid"; });

}  // namespace
}  // namespace concord::relative
