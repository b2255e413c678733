#include "relative/dynamics/loops.h"

#include <gtest/gtest.h>

#include "machines.h"
#include "relative/start/assembly.h"

namespace concord::relative {
namespace {

/// The dense Mbar of the opened tree from its accelerations: columns of responses to unit speeds are not at hand, so B
/// is used.
MatX dense_Mbar(const Equations& equations, const Evaluated& evaluated) {
  const Kinematics& kinematics = equations.kinematics();
  const MatX B = kinematics.explicit_B();
  MatX M = MatX::Zero(B.rows(), B.rows());
  for (std::size_t l = 0; l < equations.topology().links.size(); ++l) {
    const BodyInertia& inertia = evaluated.inertias()[l];
    const int row = kinematics.first_row(equations.topology().links[l].body);
    const int m = inertia.flexible() == nullptr ? 0 : inertia.flexible()->n_modes();
    Mat6 M_rr;
    inertia.moments().fill(M_rr);
    M.block<6, 6>(row, row) = M_rr;
    if (m == 0) continue;
    M.block(row, row + 6, 6, m) = inertia.flexible()->M_ra();
    M.block(row + 6, row, m, 6) = inertia.flexible()->M_ra().transpose();
    M.block(row + 6, row + 6, m, m) = inertia.flexible()->M_aa();
  }
  return B.transpose() * M * B;
}

/// Two loops that share links: the slider-crank with a further body between coupler and ground.
Model two_loops(bool flexible) {
  Model model = test::spatial_slider_crank(flexible);
  test::Numbers numbers(77);
  model.joints[3] = test::fitting_joint(model, "D", "cylindrical", 3, 0, Vec3(0.61, 0.11, 0.13), numbers);
  model.bodies.push_back(test::rigid_body("rocker", numbers));
  model.bodies.back().pose_guess = Pose{numbers.vector(0.4), numbers.rotation()};
  model.joints.push_back(test::fitting_joint(model, "E", "spherical", 2, 4, Vec3(0.31, -0.2, 0.1), numbers));
  model.joints.push_back(test::fitting_joint(model, "F", "universal", 4, 0, Vec3(0.25, -0.5, 0.3), numbers));
  return model;
}

Model machine_named(const std::string& name) {
  return name == "ladder" ? test::ladder(true) : two_loops(name == "flexible");
}

class ClosedLoops : public ::testing::TestWithParam<const char*> {};

TEST_P(ClosedLoops, MultipliersAndAccelerationsSolveTheBorderedSystem) {
  const Model model = machine_named(GetParam());
  Equations equations(model);
  const Coordinates pose = Assembly(equations).start();
  const bool is_ladder = GetParam() == std::string("ladder");
  ASSERT_EQ(equations.closure().cuts().size(), is_ladder ? 4u : 2u);
  EXPECT_EQ(equations.closure().n_rows() - equations.loops().rank(), is_ladder ? 1 : 0);
  const Evaluated& evaluated = equations.compute_accelerations(0.0, pose.q, pose.u);
  const VecX udot = evaluated.udot().head(equations.topology().n_tree_u);
  const VecX lambda = evaluated.loops().lambda;
  const MatX Phi = equations.closure().Phi_u();
  const MatX Mbar = dense_Mbar(equations, evaluated);

  // The open tree: same pose with the loops' multipliers left out.
  ArticulatedInertias tree(equations.kinematics(), equations.driven());
  TreeAccelerations open(equations.kinematics(), tree);
  const VecX nothing = VecX::Zero(equations.topology().n_u);
  tree.compute(evaluated.inertias(), evaluated.applied_forces(), nothing);
  open.solve(tree, nothing);
  const VecX gbar = Mbar * open.udot().head(udot.size());
  EXPECT_LT((Mbar * udot + Phi.transpose() * lambda - gbar).norm(), 1e-11 * gbar.norm());
  VecX residual(equations.closure().n_rows());
  const auto acceleration = [&](JointIndex joint, Side side) {
    return evaluated.accelerations().of_point(joint, side);
  };
  equations.closure().compute_acceleration_residual(acceleration, evaluated.udot(), residual);
  EXPECT_LT(residual.norm(), 1e-11 * udot.norm());
  EXPECT_GT(lambda.norm(), 0.1);
}

INSTANTIATE_TEST_SUITE_P(Machines, ClosedLoops, ::testing::Values("rigid", "flexible", "ladder"),
                         [](const auto& tested) { return tested.param; });

TEST(Loops, RefusesAPoseOfLowerRankByName) {
  const Model model = test::four_bar(true);
  Equations equations(model);
  Assembly assembly(equations);
  Coordinates folded{0.0, equations.home(), VecX::Zero(equations.topology().n_u)};
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    folded.q.segment(equations.topology().joints[k].first_q, 1) = model.joints[k].start[0].q;
  }
  assembly.decide_rank(folded);
  EXPECT_EQ(equations.loops().rank(), 2);
  try {
    assembly.closure_rank().require_general(folded, equations.compute_accelerations(0.0, folded.q, folded.u));
    FAIL() << "a folded four-bar was accepted";
  } catch (const SingularPose& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("the pose is singular and the motion may branch"), std::string::npos) << text;
    EXPECT_NE(text.find("the loop of joint"), std::string::npos) << text;
  }
}

/// The rows that a pose gets, and the accelerations, are those of the pose, whatever was evaluated before.
TEST(Loops, ChooseRowsByThePoseAlone) {
  const Model model = test::four_bar();
  const auto accelerations = [&](bool elsewhere_before) {
    Equations equations(model);
    Assembly assembly(equations);
    Coordinates pose = assembly.start();
    if (elsewhere_before) {
      for (const double turn : {0.4, 1.1, -0.7}) {
        Coordinates other = pose;
        other.q(equations.topology().joints[0].first_q) += turn;
        if (assembly.close(other)) equations.compute_accelerations(0.0, other.q, other.u);
      }
    }
    const Evaluated& evaluated = equations.compute_accelerations(0.0, pose.q, pose.u);
    EXPECT_EQ(evaluated.loops().used.rows.size(), 2u);
    EXPECT_GT(evaluated.loops().least_pivot, 1e-3);
    return VecX(evaluated.udot());
  };
  EXPECT_EQ(accelerations(false), accelerations(true));
}

}  // namespace
}  // namespace concord::relative
