#include "cartesian/rank/rank.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "cartesian/rank/clear_rows.h"
#include "common/decompositions.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

SparseMatrix sparse(const MatX& matrix) { return matrix.sparseView().cast<double>(); }

/// Rows of unit norm of which the last is a combination of two others.
MatX dependent_rows(int rows, int columns) {
  testing::Numbers numbers(71);
  MatX matrix = numbers.matrix(rows, columns);
  matrix.row(rows - 1) = matrix.row(0) - 2.0 * matrix.row(1);
  return matrix.rowwise().normalized();
}

void expect_one_dependent(const MatX& matrix) {
  const RankDecision decision = decide_rank(sparse(matrix));
  EXPECT_EQ(decision.rank, matrix.rows() - 1);
  ASSERT_EQ(decision.left_null_space.cols(), 1);
  EXPECT_LT((decision.left_null_space.transpose() * matrix).norm(), 1e-12);
  EXPECT_NEAR(decision.left_null_space.norm(), 1.0, 1e-12);
  const std::set<Eigen::Index> independent(decision.independent.begin(), decision.independent.end());
  EXPECT_EQ(std::ssize(independent), matrix.rows() - 1);
}

TEST(Rank, FindsADependentRowBySingularValues) { expect_one_dependent(dependent_rows(7, 12)); }

TEST(Rank, FindsADependentRowBySparseQr) { expect_one_dependent(dependent_rows(520, 560)); }

/// Two rows that are nearly the same, rows that are nearly dependent only together, more rows than columns, a row of
/// zeros, and what is no number.
TEST(Rank, RowsThatHardlyDifferAreNotClear) {
  testing::Numbers numbers(74);
  const MatX matrix = numbers.matrix(20, 40).rowwise().normalized();
  const auto is_clear = [](const MatX& changed) {
    const SparseMatrix rows = sparse(changed);
    return ClearRows(rows).are_independent();
  };
  EXPECT_TRUE(is_clear(matrix));
  MatX near = matrix;
  near.row(7) = (matrix.row(3) + 5e-4 * matrix.row(7)).normalized();
  EXPECT_FALSE(is_clear(near));
  MatX chained = MatX::Identity(20, 40);
  for (Eigen::Index row = 1; row < 20; ++row) chained(row, row - 1) = -2.0;
  EXPECT_FALSE(is_clear(chained.rowwise().normalized()));
  EXPECT_FALSE(is_clear(matrix.transpose()));
  MatX empty = matrix;
  empty.row(5).setZero();
  EXPECT_FALSE(is_clear(empty));
  MatX spoilt = matrix;
  spoilt(2, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_clear(spoilt));
}

/// On the way of a row into another one: never where a singular value is small, and mostly without a factorization.
TEST(Rank, RowsBesideClearOnesAreClear) {
  testing::Numbers numbers(75);
  const MatX matrix = numbers.matrix(20, 40).rowwise().normalized();
  RowsOnceClear rows;
  int clear = 0;
  for (int step = 0; step <= 1000; ++step) {
    MatX here = matrix;
    here.row(7) = (matrix.row(3) + (1.0 - 1e-3 * step) * matrix.row(7)).normalized();
    if (!rows.are_independent(sparse(here))) continue;
    ++clear;
    EXPECT_GT(singular_values(here).minCoeff(), 0.7e-4);
  }
  EXPECT_GT(clear, 990);
  EXPECT_LT(clear, 1001);
}

/// Two rows that differ by a part of 1e-7, 3e-10 or 1e-14: kept, in doubt, dropped.
TEST(Rank, SmallSingularValuesAreFoundExactly) {
  testing::Numbers numbers(72);
  for (const int rows : {9, 80}) {
    for (const double apart : {1e-7, 3e-10, 1e-14}) {
      SCOPED_TRACE(apart);
      MatX matrix = numbers.matrix(rows, 2 * rows).rowwise().normalized();
      VecX off = numbers.matrix(2 * rows, 1);
      off -= matrix.transpose() * solve_square(matrix * matrix.transpose(), matrix * off);
      matrix.row(rows - 1) = (matrix.row(2) + apart * off.normalized().transpose()).normalized();
      const RankDecision decision = decide_rank(sparse(matrix));
      const VecX values = singular_values(matrix);
      const double smallest = values(rows - 1) / values(0);
      EXPECT_EQ(decision.rank, smallest > 1e-10 ? rows : rows - 1);
      EXPECT_EQ(decision.left_null_space.cols(), rows - decision.rank);
      if (apart > 1e-12) {
        ASSERT_EQ(decision.near_values.size(), 1);
        EXPECT_NEAR(decision.near_values(0), smallest, 0.2 * smallest);
        EXPECT_LT((decision.near_null_space.transpose() * matrix).norm(), 1.1 * smallest * values(0));
      }
    }
  }
}

/// One row leaves another next to nothing, and that is what a third one says: two of the three are independent.
TEST(Rank, WhatARowLeavesOfAnotherMayStandInAThird) {
  testing::Numbers numbers(73);
  for (const int rows : {9, 80, 300}) {
    for (const int third : {0, rows / 2, rows - 1}) {
      SCOPED_TRACE(fmt::format("{} rows, {}", rows, third));
      MatX matrix = numbers.matrix(rows, rows + 20).rowwise().normalized();
      const int one = third == 0 ? 1 : 0;
      const int other = rows - 3;
      matrix.row(other) = (matrix.row(one) + 1e-7 * matrix.row(third)).normalized();
      const RankDecision decision = decide_rank(sparse(matrix));
      EXPECT_EQ(decision.rank, rows - 1);
      ASSERT_EQ(decision.left_null_space.cols(), 1);
      EXPECT_LT((decision.left_null_space.transpose() * matrix).norm(), 1e-13);
    }
  }
}

TEST(Rank, RowsThatGoFirstStayWhereRowsDependOnEachOther) {
  for (const int rows : {7, 90}) {
    const MatX matrix = dependent_rows(rows, rows + 40);  // the first, the second and the last depend on each other
    for (const int last : {0, 1, rows - 1}) {
      std::vector<bool> goes_first(rows, true);
      goes_first[last] = false;
      const RankDecision decision = decide_rank(sparse(matrix), &goes_first);
      EXPECT_EQ(decision.rank, rows - 1);
      EXPECT_EQ(std::count(decision.independent.begin(), decision.independent.end(), last), 0);
    }
  }
}

TEST(Rank, ShortestSolutionLeavesDependentRowsOut) {
  const MatX matrix = dependent_rows(5, 9);
  const VecX known = matrix.transpose() * VecX::LinSpaced(5, -1.0, 2.0);  // in the row space: already the shortest
  ShortestSolver solver;
  const VecX x = solve_shortest(sparse(matrix), matrix * known, solver);
  EXPECT_LT((matrix * (x - known)).norm(), 1e-13);
}

TEST(Rank, OneSolverServesOneMatrixAfterTheOther) {
  const MatX first = dependent_rows(6, 9).topRows(5);
  const MatX dependent = [&] {
    MatX rows = first;
    rows.row(4) = (rows.row(0) + rows.row(2)).normalized();
    return rows;
  }();
  const MatX near = first + 1e-12 * first.rowwise().reverse();
  MatX other_pattern = first;
  other_pattern.leftCols(4).triangularView<Eigen::StrictlyLower>().setZero();
  ShortestSolver one;
  for (const MatX& matrix : {first, near, MatX(first.rowwise().reverse()), dependent, other_pattern, first}) {
    const VecX b = matrix * VecX::LinSpaced(9, -1.0, 2.0);
    ShortestSolver anew;
    const ShortestSolution found = one.solve(sparse(matrix.transpose()), b, 1e-8);
    const ShortestSolution expected = anew.solve(sparse(matrix.transpose()), b, 1e-8);
    EXPECT_EQ(found.rank, expected.rank);
    EXPECT_LT((found.x - expected.x).norm(), 1e-10 * expected.x.norm());
    EXPECT_LT((matrix * found.x - b).norm(), 1e-10 * b.norm());
  }
}

}  // namespace
}  // namespace concord::cartesian
