#include "relative/dynamics/reactions.h"

#include <gtest/gtest.h>

#include "machines.h"
#include "relative/solver.h"
#include "relative/start/assembly.h"

namespace concord::relative {
namespace {

/// Round-off that the wrenches of a machine may leave: 1e-13 of the largest force or torque.
double round_off(const Evaluation& evaluation) {
  double largest = 1.0;
  for (const JointWrenches& joint : evaluation.joints) {
    for (const SideWrench& side : joint.total) largest = std::max(largest, side.in_global.vector().norm());
  }
  return 1e-13 * largest;
}

void expect_balanced(const Model& model, const State& state, const Evaluation& evaluation) {
  const test::Imbalance left_over = test::imbalance(model, state, evaluation);
  const double allowed = 10.0 * round_off(evaluation);
  EXPECT_LT(left_over.force, allowed);
  EXPECT_LT(left_over.torque, allowed);
  EXPECT_LT(left_over.modal, allowed);
}

/// S^T w = 0 for the reaction on the child at P_i in the parent's joint frame, forces answered with their lever on the
/// parent, and the two frames of each side one wrench.
void expect_ideal(const Model& model, const State& state, const Evaluation& evaluation) {
  const double allowed = round_off(evaluation);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    const auto frame = [&](Side side) {
      const Attachment& at = joint.on(side);
      const BodyState& body = state.bodies[at.body];
      const Vec3 theta = at.Psi_r_L * body.a;
      const Mat3 R = theta.norm() > 0.0 ? rotation_about(Vec3(theta.normalized()), theta.norm()) : Mat3::Identity();
      const Mat3 A = test::rotation_of(body);
      return Pose{body.r + A * (at.point_L + at.Psi_t_L * body.a), A * R * at.C};
    };
    const Pose parent = frame(Side::parent);
    const Pose child = frame(Side::child);
    JointMotion motion;
    Mobilizer(*joint.type).evaluate(state.q[k].data(), state.u[k].data(), motion);
    const SideWrench& on_child = evaluation.joints[k].reaction_on(Side::child);
    Vec6 in_parent_axes;
    in_parent_axes << parent.A.transpose() * on_child.in_global.force, parent.A.transpose() * on_child.in_global.torque;
    const Mat6X S = motion.S.leftCols(joint.type->n_u());
    EXPECT_LT((S.transpose() * in_parent_axes).norm(), 10.0 * allowed) << joint.name;
    for (const auto* wrenches : {&evaluation.joints[k].reaction, &evaluation.joints[k].total}) {
      const SideWrench& c = (*wrenches)[1];
      const SideWrench& p = (*wrenches)[0];
      EXPECT_LT((p.in_global.force + c.in_global.force).norm(), allowed);
      EXPECT_LT((p.in_global.torque + c.in_global.torque + (child.r - parent.r).cross(c.in_global.force)).norm(),
                allowed);
      EXPECT_LT((child.A * c.in_C.force - c.in_global.force).norm(), allowed);
      EXPECT_LT((child.A * c.in_C.torque - c.in_global.torque).norm(), allowed);
      EXPECT_LT((parent.A * p.in_C.force - p.in_global.force).norm(), allowed);
      EXPECT_LT((parent.A * p.in_C.torque - p.in_global.torque).norm(), allowed);
    }
  }
}

class WrenchesOfTree : public ::testing::TestWithParam<bool> {};

TEST_P(WrenchesOfTree, BalanceEveryBodyAndDoNoWork) {
  const Model model = test::tree_of_all_joints(GetParam());
  const std::unique_ptr<Solver> solver = make_solver(model);
  const State state = solver->assemble();
  const Evaluation evaluation = solver->evaluate(state);
  expect_balanced(model, state, evaluation);
  expect_ideal(model, state, evaluation);
}

INSTANTIATE_TEST_SUITE_P(Trees, WrenchesOfTree, ::testing::Bool(),
                         [](const auto& tested) { return tested.param ? "flexible" : "rigid"; });

class WrenchesOfLoop : public ::testing::TestWithParam<std::tuple<bool, int>> {
 protected:
  WrenchesOfLoop() : model_(test::spatial_slider_crank(std::get<0>(GetParam()))), cut_(model_) {
    cut_.joints[std::get<1>(GetParam())].named_as_cut = true;
  }
  Model model_;
  Model cut_;
};

TEST_P(WrenchesOfLoop, BalanceEveryBodyAndDoNoWork) {
  const std::unique_ptr<Solver> solver = make_solver(cut_);
  const State state = solver->assemble();
  const Evaluation evaluation = solver->evaluate(state);
  expect_balanced(model_, state, evaluation);
  expect_ideal(model_, state, evaluation);
}

TEST_P(WrenchesOfLoop, DoNotDependOnTheCutJoint) {
  const State state = make_solver(model_)->assemble();
  const Evaluation as_ruled = make_solver(model_)->evaluate(state);
  const Evaluation as_named = make_solver(cut_)->evaluate(state);
  for (std::size_t k = 0; k < model_.joints.size(); ++k) {
    for (const Side side : {Side::parent, Side::child}) {
      const Vec6 difference =
          as_ruled.joints[k].reaction_on(side).in_C.vector() - as_named.joints[k].reaction_on(side).in_C.vector();
      EXPECT_LT(difference.norm(), 100.0 * round_off(as_ruled)) << model_.joints[k].name;
    }
  }
}

/// The driven crank or the driven slide, as tree joint and as cut joint.
TEST_P(WrenchesOfLoop, SplitDriversOffWhereverTheyAre) {
  for (const int driven : {0, 3}) {
    Model model = cut_;
    const State free = make_solver(model_)->assemble();
    const double q = free.q[driven](0);
    model.joints[0].start[0].role_q = StartRole::guess;
    model.joints[0].start[0].role_u = StartRole::guess;
    model.joints[driven].drivers.push_back({0, Harmonic{q - 0.02, 0.04, 7.0, M_PI / 6.0}});
    const std::unique_ptr<Solver> solver = make_solver(model);
    const State state = solver->assemble();
    EXPECT_EQ(state.q[driven](0), evaluate(model.joints[driven].drivers[0].law, 0.0).f);
    EXPECT_EQ(state.u[driven](0), evaluate(model.joints[driven].drivers[0].law, 0.0).fdot);
    const Evaluation evaluation = solver->evaluate(state);
    expect_balanced(model, state, evaluation);
    expect_ideal(model, state, evaluation);
    EXPECT_GT(std::abs(evaluation.joints[driven].tau(0)), 1e-3);
    // tau = S^T total: the driven axis is z of the parent's frame for both.
    const Wrench& total = evaluation.joints[driven].total_on(Side::child).in_C;
    EXPECT_NEAR(evaluation.joints[driven].tau(0), driven == 0 ? total.torque.z() : total.force.z(), 1e-11);
  }
}

INSTANTIATE_TEST_SUITE_P(CutAtEach, WrenchesOfLoop, ::testing::Combine(::testing::Bool(), ::testing::Range(0, 4)));

/// What Step 5 leaves of the modal rows of all bodies, as a part of the largest wrench.
double modal_rows_left_by(const Reactions& reactions, const JointReactions& found, const Topology& topology) {
  double left = 0.0;
  for (const LinkIndex l : upward<LinkIndex>(topology.links.size())) {
    if (reactions.rho_a(l).size() > 0) left = std::max(left, reactions.rho_a(l).cwiseAbs().maxCoeff());
  }
  double largest = 0.0;
  for (const JointWrenches& joint : found.joints) {
    for (const SideWrench& side : joint.total) largest = std::max(largest, side.in_global.vector().norm());
  }
  return left / largest;
}

TEST(Reactions, ModalRowsOfStepFiveVanishForTheRightMultipliersAlone) {
  const Model model = test::spatial_slider_crank(true);
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  const Evaluated& evaluated = equations.compute_accelerations(0.0, start.q, start.u);
  Reactions reactions(equations.kinematics(), equations.closure());
  const auto left = [&](double factor) {
    const JointReactions& found = reactions.compute(evaluated.inertias(), evaluated.accelerations(),
                                                    evaluated.applied_forces(), factor * evaluated.loops().lambda);
    return modal_rows_left_by(reactions, found, equations.topology());
  };
  EXPECT_LT(left(1.0), 1e-12);
  EXPECT_GT(left(1.1), 1e-4);
}

TEST(Reactions, SelfStressIsInEquilibriumWithoutLoad) {
  const Model model = test::four_bar();
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  const Motion& motion = equations.move(0.0, start.q, start.u);
  const MatX Phi = equations.closure().Phi_u();
  const Eigen::JacobiSVD<MatX> svd(Phi, Eigen::ComputeFullU);
  ASSERT_LT(svd.singularValues()(2), 1e-14);
  const JointReactions& stress = equations.compute_self_stress(motion, svd.matrixU().col(4));
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    Vec3 force = Vec3::Zero();
    Vec3 torque = Vec3::Zero();
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      for (const Side side : {Side::parent, Side::child}) {
        if (model.joints[k].on(side).body != static_cast<int>(i)) continue;
        const Wrench& w = stress.joints[k].total_on(side).in_global;
        force += w.force;
        torque += w.torque + equations.kinematics().point(JointIndex(k), side).r.cross(w.force);
      }
    }
    EXPECT_LT(force.norm(), 1e-14);
    EXPECT_LT(torque.norm(), 1e-14);
  }
  for (const JointWrenches& joint : stress.joints) {
    EXPECT_NEAR(joint.reaction_on(Side::child).in_C.torque.z(), 0.0, 1e-13);
  }
}

}  // namespace
}  // namespace concord::relative
