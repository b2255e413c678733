#include "relative/row_factors.h"

#include <gtest/gtest.h>

#include "common/decompositions.h"
#include "machines.h"

namespace concord::relative {
namespace {

MatX random_rows(Eigen::Index n, Eigen::Index columns, unsigned seed) {
  test::Numbers numbers(seed);
  MatX rows(n, columns);
  for (Eigen::Index c = 0; c < columns; ++c) rows.col(c) = numbers.vector(n, 1.0);
  return rows;
}

TEST(RowFactors, FindTheSmallestStepOfIndependentRows) {
  const MatX Phi = random_rows(4, 7, 3);
  RowFactors factors;
  factors.compute(Phi);
  EXPECT_EQ(factors.rank(), 4);
  const VecX misfit = (VecX(4) << 0.3, -0.2, 0.7, 0.1).finished();
  const VecX step = factors.smallest_step(misfit);
  EXPECT_LT((Phi * step + misfit).norm(), 1e-14);
  const VecX least = -smallest_least_squares(Phi, misfit);
  EXPECT_LT((step - least).norm(), 1e-13);
}

TEST(RowFactors, MeasureTheSmallestSingularValueThatCounts) {
  for (const double size : {1.0, 1e-3, 1e-7}) {
    MatX Phi = random_rows(5, 8, 11);
    Phi.row(3) = 0.4 * Phi.row(0) - 1.2 * Phi.row(1) + size * random_rows(1, 8, 12);
    Phi.row(4) = 2.0 * Phi.row(2) - Phi.row(0);  // one row too many
    RowFactors factors;
    factors.compute(Phi);
    EXPECT_EQ(factors.rank(), 4);
    const VecX sigma = singular_values(Phi);
    const double found = factors.singular_value(4);
    EXPECT_GT(found, 0.2 * sigma(3)) << size;
    EXPECT_LT(found, 1.5 * sigma(3)) << size;
    const VecX weakest = factors.weakest_combination(4);
    EXPECT_NEAR(weakest.norm(), 1.0, 1e-12);
    EXPECT_LT((Phi.transpose() * weakest).norm(), 2.0 * sigma(3)) << size;
  }
}

TEST(RowFactors, OfNothingAreRegularAndOfTooFewColumnsAreNot) {
  RowFactors factors;
  factors.compute(MatX(0, 5));
  EXPECT_EQ(factors.rank(), 0);
  EXPECT_EQ(factors.singular_value(0), 1.0);
  EXPECT_EQ(factors.smallest_step(VecX(0)), VecX::Zero(5));
  factors.compute(random_rows(3, 2, 9));
  EXPECT_EQ(factors.rank(), 2);
  EXPECT_EQ(factors.singular_value(3), 0.0);
}

}  // namespace
}  // namespace concord::relative
