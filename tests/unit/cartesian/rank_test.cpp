#include "cartesian/rank.h"

#include <gtest/gtest.h>

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
  EXPECT_EQ(std::count(decision.independent.begin(), decision.independent.end(), false), 1);
}

TEST(Rank, FindsADependentRowBySingularValues) { expect_one_dependent(dependent_rows(7, 12)); }

TEST(Rank, FindsADependentRowBySparseQr) { expect_one_dependent(dependent_rows(520, 560)); }

TEST(Rank, ShortestSolutionLeavesDependentRowsOut) {
  const MatX matrix = dependent_rows(5, 9);
  const VecX known = matrix.transpose() * VecX::LinSpaced(5, -1.0, 2.0);  // in the row space: already the shortest
  const VecX x = solve_shortest(sparse(matrix), matrix * known);
  EXPECT_LT((matrix * (x - known)).norm(), 1e-13);
}

}  // namespace
}  // namespace concord::cartesian
