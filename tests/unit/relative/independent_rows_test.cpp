#include "relative/dynamics/independent_rows.h"

#include <gtest/gtest.h>

#include "relative/dynamics/multiplier_factors.h"

namespace concord::relative {
namespace {

/// Lambda of five rows of rank three: the second is twice the first, the fourth the sum of the first and the third.
MatX dependent_Lambda() {
  MatX rows(5, 4);
  rows.row(0) << 1.0, 2.0, -1.0, 0.5;
  rows.row(1) = 2.0 * rows.row(0);
  rows.row(2) << 0.3, -0.7, 1.1, 2.0;
  rows.row(3) = rows.row(0) + rows.row(2);
  rows.row(4) << -1.2, 0.4, 0.9, -0.6;
  return rows * rows.transpose();
}

IndependentRows scaled(const MatX& Lambda) {
  IndependentRows rows(Lambda.rows());
  scale_rows(Lambda.diagonal(), VecX::Ones(Lambda.rows()), rows);
  return rows;
}

TEST(IndependentRows, AreTheFirstThatHaveEnoughOfTheirOwn) {
  const MatX Lambda = dependent_Lambda();
  IndependentRows rows = scaled(Lambda);
  RowChoice choice(Lambda.rows());
  ASSERT_TRUE(choice.choose(Lambda, 3, rows));
  EXPECT_EQ(rows.rows, (std::vector{RowIndex(0), RowIndex(2), RowIndex(4)}));
  EXPECT_TRUE(rows.hold(RowIndex(2)));
  EXPECT_FALSE(rows.hold(RowIndex(3)));
}

/// Rows a million times larger than the others are not better ones.
TEST(IndependentRows, DoNotDependOnTheUnitsOfRows) {
  const VecX units = (VecX(5) << 1.0, 1e6, 1.0, 1e6, 1e-6).finished();
  const MatX Lambda = units.asDiagonal() * dependent_Lambda() * units.asDiagonal();
  IndependentRows rows(5);
  scale_rows(Lambda.diagonal(), units, rows);
  for (int row = 0; row < 5; ++row) EXPECT_NEAR(Lambda(row, row) * rows.scale(row) * rows.scale(row), 1.0, 1e-14);
  RowChoice choice(5);
  ASSERT_TRUE(choice.choose(Lambda, 3, rows));
  EXPECT_EQ(rows.rows, (std::vector{RowIndex(0), RowIndex(2), RowIndex(4)}));
}

TEST(IndependentRows, ARowOfRoundOffVanishes) {
  MatX Lambda = dependent_Lambda();
  Lambda.row(2) *= 1e-12;
  Lambda.col(2) *= 1e-12;
  EXPECT_EQ(scaled(Lambda).scale(2), 0.0);
  EXPECT_GT(scaled(Lambda).scale(4), 0.0);
}

/// As that of Hooke's joint in the pose in which its parent's pin stands across the plane of the shafts.
TEST(IndependentRows, AreNotThoseThatAlmostVanishWhereOthersSayTheSame) {
  MatX Lambda = dependent_Lambda();
  Lambda.row(0) *= 1e-9;
  Lambda.col(0) *= 1e-9;
  IndependentRows rows = scaled(Lambda);
  RowChoice choice(Lambda.rows());
  ASSERT_TRUE(choice.choose(Lambda, 3, rows));
  EXPECT_EQ(rows.rows, (std::vector{RowIndex(1), RowIndex(2), RowIndex(4)}));
  EXPECT_EQ(rows.least_weight(), 1.0);
  rows.rows.front() = RowIndex(0);
  EXPECT_LT(rows.least_weight(), 1e-14);
}

/// As that of a straight beam along itself between two hinges: nothing else says it, but to second order.
TEST(IndependentRows, AreThoseThatAlmostVanishRatherThanRoundOff) {
  MatX rows(3, 2);
  rows.row(0) << 1.0, 2.0;
  rows.row(1) << 2.0, 4.0 + 1e-14;
  rows.row(2) << 3e-9, -2e-9;
  const MatX Lambda = rows * rows.transpose();
  IndependentRows found = scaled(Lambda);
  RowChoice choice(3);
  ASSERT_TRUE(choice.choose(Lambda, 2, found));
  EXPECT_EQ(found.rows, (std::vector{RowIndex(0), RowIndex(2)}));
}

/// Both factors solve the same equations, and tell how near to dependent the rows are.
TEST(MultiplierFactors, SolveTheChosenRows) {
  const MatX Lambda = dependent_Lambda();
  IndependentRows rows = scaled(Lambda);
  RowChoice choice(Lambda.rows());
  ASSERT_TRUE(choice.choose(Lambda, 3, rows));
  LambdaBlocks blocks(EliminationOrder({{0, 5}}, {{}}));
  for (int i = 0; i < 25; ++i) blocks.values(0)[i] = Lambda(i / 5, i % 5);
  MultiplierFactors factors(blocks);
  factors.lay_out(3, 4);
  const double pivot = factors.factor(rows);
  EXPECT_GT(pivot, 0.01);
  EXPECT_LE(pivot, 1.0);
  const VecX right = (VecX(3) << 0.4, -1.3, 2.2).finished();
  VecX found = right;
  factors.solve(rows, found);
  MatX chosen(3, 3);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) chosen(i, j) = Lambda(rows.rows[i].value(), rows.rows[j].value());
  }
  EXPECT_LT((chosen * found - right).norm(), 1e-13);

  // The same from a square root of the scaled rows.
  VecX scale(3);
  for (int i = 0; i < 3; ++i) scale(i) = rows.scale[rows.rows[i]];
  const MatX root = Eigen::LLT<MatX>(scale.asDiagonal() * chosen * scale.asDiagonal()).matrixL();
  factors.stacked().topRows(3) = root.transpose();
  factors.stacked().bottomRows(1).setZero();
  const MultiplierFactors::LeastSine least = factors.factor_stacked();
  EXPECT_GT(least.pivot, 0.1);
  EXPECT_LT(least.place, 3);
  VecX again = right;
  factors.solve(rows, again);
  EXPECT_LT((again - found).norm(), 1e-13 * found.norm());
}

}  // namespace
}  // namespace concord::relative
