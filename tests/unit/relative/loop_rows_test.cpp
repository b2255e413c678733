#include "relative/rank/loop_rows.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>

#include "machines.h"
#include "relative/rank/closing.h"
#include "relative/rank/row_rank.h"
#include "relative/start/assembly.h"

namespace concord::relative {
namespace {

/// Loops that share bodies: a ladder whose feet stand on a flexible body that flies, so that no loop reaches ground.
Model flying_ladder() {
  Model model = test::ladder(false);
  test::Numbers numbers(19);
  model.bodies.push_back(test::flexible_body("frame", 3, numbers));
  const int frame = static_cast<int>(model.bodies.size()) - 1;
  model.bodies.back().pose_guess = Pose{numbers.vector(0.3), numbers.rotation()};
  for (Joint& joint : model.joints) {
    if (joint.sides[0].body != kGround) continue;
    const int crank = joint.sides[1].body;
    joint = test::fitting_joint(model, joint.name, "revolute", frame, crank, Vec3(0.4 * crank, 0.1, 0), numbers);
  }
  test::keep_first_word(model.joints[0], 1.6);
  model.joints.push_back(test::fitting_joint(model, "flight", "free", 0, frame, Vec3(0.1, 0.2, 0.3), numbers));
  for (WordStart& word : model.joints.back().start) word.role_q = word.role_u = StartRole::keep;
  return model;
}

Model machine(const std::string& name) {
  if (name == "ladder") return test::ladder(false);
  if (name == "flying") return flying_ladder();
  Model model = test::spatial_slider_crank(name == "flexible");
  if (name != "driven") return model;
  test::release(model.joints[0]);
  model.joints[0].drivers.push_back({0, Harmonic{model.joints[0].start[0].q(0), 0.3, 4.0, 0.0}});
  return model;
}

class Rows : public ::testing::TestWithParam<const char*> {};

/// In a pose that is not closed, for every column and for weights.
TEST_P(Rows, OfLoopsTakeTheStepAndHaveTheSingularValueOfDenseRows) {
  const Model model = machine(GetParam());
  Equations equations(model);
  Assembly assembly(equations);
  Coordinates pose = assembly.start();
  const ScaledClosure& scaled = assembly.scaled();
  test::Numbers numbers(3);
  const std::vector<int>& columns = scaled.free_columns();
  pose.q.head(equations.topology().n_tree_q) += numbers.vector(equations.topology().n_tree_q, 1e-3);
  scaled.normalize(pose.q);
  scaled.move(pose);
  LoopRows rows(scaled);
  for (const double lightest : {1.0, 0.2}) {
    VecX weights(columns.size());
    for (double& weight : weights) weight = lightest + (1.0 - lightest) * std::abs(numbers());
    ASSERT_TRUE(rows.factor(weights));
    const MatX Phi = scaled.rows(columns) * weights.asDiagonal();
    const VecX misfit = numbers.vector(Phi.rows(), 1.0);
    const VecX dense = RowRank(Phi).smallest_step(misfit);
    const double least = Eigen::JacobiSVD<MatX>(Phi).singularValues().minCoeff();
    EXPECT_NEAR(rows.singular_value(), least, 0.02 * least);
    const VecX found = rows.smallest_step(misfit);
    EXPECT_LT((found - dense).norm(), 1e-10 * dense.norm());
    EXPECT_LT((Phi * found + misfit).norm(), 1e-10 * misfit.norm());
  }
}

/// Over the columns of joints alone, as a machine is closed.
TEST_P(Rows, OfLoopsTakeTheStepOverGivenColumns) {
  const Model model = machine(GetParam());
  Equations equations(model);
  Assembly assembly(equations);
  Coordinates pose = assembly.start();
  const ScaledClosure& scaled = assembly.scaled();
  scaled.move(pose);
  const std::vector<int> columns = scaled.moving_columns(equations.driven(), Modes::kept);
  LoopRows rows(scaled, scaled.closure(), columns);
  ASSERT_TRUE(rows.factor(VecX::Ones(static_cast<Eigen::Index>(columns.size()))));
  const MatX Phi = scaled.rows(columns);
  test::Numbers numbers(5);
  const VecX misfit = numbers.vector(Phi.rows(), 1.0);
  const VecX found = rows.smallest_step(misfit);
  ASSERT_EQ(found.size(), Phi.cols());
  EXPECT_LT((found - RowRank(Phi).smallest_step(misfit)).norm(), 1e-10 * found.norm());
}

INSTANTIATE_TEST_SUITE_P(Machines, Rows, ::testing::Values("rigid", "flexible", "driven", "ladder", "flying"),
                         [](const auto& tested) { return tested.param; });

/// Damped, and without damping where squares alone leave too few digits, as of many loops that pass motion on.
TEST(LoopRows, TakeTheStepsOfManyRows) {
  const Model model = test::ladder(false, 60);
  Equations equations(model);
  const ScaledClosure scaled(equations);
  Coordinates pose{0.0, equations.home(), VecX::Zero(equations.topology().n_u)};
  test::Numbers numbers(4);
  pose.q.head(equations.topology().n_tree_q) += numbers.vector(equations.topology().n_tree_q, 0.3);
  scaled.normalize(pose.q);
  scaled.move(pose);
  LoopRows rows(scaled);
  ASSERT_TRUE(rows.factor(VecX::Ones(static_cast<Eigen::Index>(scaled.free_columns().size()))));
  EXPECT_LT(rows.singular_value(), 1e-5);
  const MatX Phi = scaled.rows(scaled.free_columns());
  const VecX misfit = numbers.vector(Phi.rows(), 1.0);
  const VecX dense = RowRank(Phi).smallest_step(misfit);
  EXPECT_LT((rows.refined_step(misfit) - dense).norm(), 1e-11 * dense.norm());
  const double damping = 1e-3;
  ASSERT_TRUE(rows.factor_damped(damping));
  const MatX squares = Phi * Phi.transpose() + damping * damping * MatX::Identity(Phi.rows(), Phi.rows());
  const VecX damped = -Phi.transpose() * squares.ldlt().solve(misfit);
  EXPECT_LT((rows.refined_step(misfit) - damped).norm(), 1e-10 * damped.norm());
}

/// Of more rows than are decomposed by rotations, dependent ones among them, far from closed.
TEST(Closing, ADampedStepOfManyRowsIsThatOfSingularValues) {
  for (const bool is_doubled : {false, true}) {
    const Model model = test::ladder(is_doubled, 8);
    Equations equations(model);
    Assembly assembly(equations);
    Coordinates pose = assembly.start();
    const ScaledClosure& scaled = assembly.scaled();
    scaled.move(pose);
    const Closure& closure = scaled.closure();
    const std::vector<int> columns = scaled.moving_columns(equations.driven(), Modes::kept);
    const MatX Phi = scaled.rows(closure, columns).topRows(closure.n_position_rows());
    ASSERT_GT(Phi.rows(), 16);
    test::Numbers numbers(6);
    const VecX misfit = numbers.vector(Phi.rows(), 1.0);
    const double damping = 1e-3;
    const VecX in_units = misfit.cwiseProduct(closure.row_units().head(misfit.size()));
    const VecX found = smallest_step(scaled, closure, columns, in_units, damping)(columns);
    const Eigen::JacobiSVD<MatX> svd(Phi, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const VecX& sigma = svd.singularValues();
    const VecX filter = sigma.array() / (sigma.array().square() + damping * damping);
    const VecX exact = -(svd.matrixV() * filter.asDiagonal() * svd.matrixU().transpose() * misfit);
    EXPECT_LT((found - exact).norm(), 1e-7 * exact.norm());
  }
}

/// Of a doubled rod, and of hinges with parallel axes: others judge there.
TEST(LoopRows, RefuseRowsThatAreNotClearlyIndependent) {
  for (const Model& model : {test::ladder(true), test::four_bar()}) {
    Equations equations(model);
    Assembly assembly(equations);
    Coordinates pose = assembly.start();
    assembly.scaled().move(pose);
    LoopRows rows(assembly.scaled());
    EXPECT_FALSE(rows.factor(VecX::Ones(static_cast<Eigen::Index>(assembly.scaled().free_columns().size()))));
  }
}

}  // namespace
}  // namespace concord::relative
