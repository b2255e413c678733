#include "relative/dynamics/articulated_inertias.h"

#include <gtest/gtest.h>

#include "common/decompositions.h"
#include "machines.h"
#include "relative/start/assembly.h"

namespace concord::relative {
namespace {

struct DenseSystem {
  MatX Mbar;
  VecX gbar;
};

/// Mbar = B^T M B and gbar = B^T (Q - S - U - M Bdot u), formed densely.
DenseSystem dense_system(const Equations& equations, const Evaluated& evaluated) {
  const Kinematics& kinematics = equations.kinematics();
  const MatX B = kinematics.explicit_B();
  MatX M = MatX::Zero(B.rows(), B.rows());
  VecX p = VecX::Zero(B.rows());
  for (std::size_t l = 0; l < equations.topology().links.size(); ++l) {
    const BodyIndex body = equations.topology().links[l].body;
    const int row = kinematics.first_row(body);
    const BodyInertia& inertia = evaluated.inertias()[l];
    Mat6 M_rr;
    inertia.moments().fill(M_rr);
    M.block<6, 6>(row, row) = M_rr;
    p.segment<6>(row) = inertia.p();
    const FlexibleInertia* flexible = inertia.flexible();
    if (flexible == nullptr) continue;
    const int m = flexible->n_modes();
    M.block(row, row + 6, 6, m) = flexible->M_ra();
    M.block(row + 6, row, m, 6) = flexible->M_ra().transpose();
    M.block(row + 6, row + 6, m, m) = flexible->M_aa();
    p.segment(row + 6, m) = flexible->p_a();
  }
  return {B.transpose() * M * B, -(B.transpose() * (p + M * kinematics.Bdot_u()))};
}

class EliminatedTree : public ::testing::TestWithParam<bool> {};

TEST_P(EliminatedTree, SolvesTheDenseEquations) {
  const Model model = test::tree_of_all_joints(GetParam());
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  const Evaluated& evaluated = equations.compute_accelerations(0.0, start.q, start.u);
  const DenseSystem dense = dense_system(equations, evaluated);
  const VecX expected = solve_square(dense.Mbar, dense.gbar);
  EXPECT_LT((evaluated.udot() - expected).norm(), 1e-11 * expected.norm());
}

TEST_P(EliminatedTree, TakesDrivenSpeedsAsGiven) {
  Model model = test::tree_of_all_joints(GetParam());
  const auto drive = [&](int joint, int word, double fddot) {
    model.joints[joint].drivers.push_back({word, Polynomial{{0.3, -0.9, 0.5 * fddot}}});
    model.joints[joint].start[word].role_q = StartRole::unsaid;
    model.joints[joint].start[word].role_u = StartRole::unsaid;
  };
  drive(0, 0, 1.1);
  drive(2, 1, -2.3);
  drive(4, 0, 0.7);
  drive(5, 1, 1.9);
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  const Evaluated& evaluated = equations.compute_accelerations(0.0, start.q, start.u);
  const DenseSystem dense = dense_system(equations, evaluated);
  const VecX residual = dense.Mbar * evaluated.udot() - dense.gbar;
  int n_driven = 0;
  for (int c = 0; c < equations.topology().n_tree_u; ++c) {
    if (equations.driven()[c] == 0) {
      EXPECT_LT(std::abs(residual(c)), 1e-10) << c;
    } else {
      ++n_driven;
    }
  }
  EXPECT_EQ(n_driven, 4);
  EXPECT_EQ(evaluated.udot()(equations.topology().joints[4].first_u), 0.7);
}

INSTANTIATE_TEST_SUITE_P(Trees, EliminatedTree, ::testing::Bool(),
                         [](const auto& tested) { return tested.param ? "flexible" : "rigid"; });

TEST(ArticulatedInertias, FindsTheMotionWithoutInertia) {
  Model model = test::spatial_slider_crank(false);
  model.joints[2].named_as_cut = true;
  // The coupler now hangs on the ball B alone: as a thin line through B it has no inertia about itself.
  Body& coupler = model.bodies[2];
  const Vec3 line = Vec3(2.0, -1.0, 2.0) / 3.0;  // along no axis of the joint
  coupler.center_of_mass_L = model.joints[1].sides[0].point_L + 0.2 * line;
  coupler.inertia_L = 0.01 * (Mat3::Identity() - line * line.transpose());
  model.joints[1].sides[0].C.setIdentity();
  model.joints[1].sides[1].C.setIdentity();
  Equations equations(model);
  VecX q = equations.home();
  const auto slack = equations.find_motion_without_inertia(0.0, q, VecX::Zero(equations.topology().n_u));
  ASSERT_TRUE(slack);
  EXPECT_EQ(equations.topology().links[slack->link].joint, 1);
  EXPECT_LT(Vec3(slack->u).cross(line).norm(), 1e-9 * slack->u.norm());
}

}  // namespace
}  // namespace concord::relative
