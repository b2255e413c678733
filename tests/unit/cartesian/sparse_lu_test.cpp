#include "cartesian/sparse_lu.h"

#include <gtest/gtest.h>

namespace concord::cartesian {
namespace {

/// [2 0 1; 0 3 0; 1 0 0] with a structural zero at (2, 2).
SparseLu make_matrix() { return {{0, 2, 3, 5}, {0, 2, 1, 0, 2}}; }

void fill(SparseLu& matrix, double corner) {
  matrix.values()[matrix.find(0, 0)] = 2.0;
  matrix.values()[matrix.find(2, 0)] = 1.0;
  matrix.values()[matrix.find(1, 1)] = 3.0;
  matrix.values()[matrix.find(0, 2)] = 1.0;
  matrix.values()[matrix.find(2, 2)] = corner;
}

TEST(SparseLu, SolvesAndRefactorsWithAFrozenPattern) {
  SparseLu matrix = make_matrix();
  fill(matrix, 0.0);
  ASSERT_TRUE(matrix.factor());
  VecX x = Vec3(4.0, 6.0, 1.0);
  ASSERT_TRUE(matrix.solve_refined(x, 1e-15));
  EXPECT_LT((x - Vec3(1.0, 2.0, 2.0)).norm(), 1e-15);
  fill(matrix, 5.0);
  ASSERT_TRUE(matrix.refactor());
  x = Vec3(3.0, 3.0, 6.0);
  ASSERT_TRUE(matrix.solve_refined(x, 1e-15));
  EXPECT_LT((x - Vec3(1.0, 1.0, 1.0)).norm(), 1e-15);
}

TEST(SparseLu, TellsASingularMatrix) {
  SparseLu matrix = make_matrix();
  fill(matrix, 0.5);  // third row is half the first
  EXPECT_FALSE(matrix.factor());
}

TEST(SparseLu, RefusesAnEntryOutsideThePattern) {
  const SparseLu matrix = make_matrix();
  EXPECT_THROW((void)matrix.find(1, 0), std::logic_error);
}

}  // namespace
}  // namespace concord::cartesian
