#include "relative/rank/row_rank.h"

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

TEST(RowRank, FindTheSmallestStepOfIndependentRows) {
  const MatX Phi = random_rows(4, 7, 3);
  const RowRank factors(Phi);
  EXPECT_EQ(factors.rank(), 4);
  const VecX misfit = (VecX(4) << 0.3, -0.2, 0.7, 0.1).finished();
  const VecX step = factors.smallest_step(misfit);
  EXPECT_LT((Phi * step + misfit).norm(), 1e-14);
  const VecX least = -smallest_least_squares(Phi, misfit);
  EXPECT_LT((step - least).norm(), 1e-13);
}

TEST(RowRank, MeasureTheSmallestSingularValueThatCounts) {
  for (const double size : {1.0, 1e-3, 1e-7}) {
    MatX Phi = random_rows(5, 8, 11);
    Phi.row(3) = 0.4 * Phi.row(0) - 1.2 * Phi.row(1) + size * random_rows(1, 8, 12);
    Phi.row(4) = 2.0 * Phi.row(2) - Phi.row(0);  // one row too many
    const RowRank factors(Phi);
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

/// Also where no column may move, so that every combination vanishes.
TEST(RowRank, SplitsRowsAndColumnsIntoWhatHoldsAndWhatDoesNot) {
  MatX Phi = random_rows(5, 8, 21);
  Phi.row(1) = 0.7 * Phi.row(0) - 0.3 * Phi.row(3);
  const RowRank rows(Phi);
  ASSERT_EQ(rows.rank(), 4);
  EXPECT_LT(rows.pivot(4), 1e-14);
  const MatX vanishing = rows.vanishing_combinations(4);
  const MatX free = rows.free_directions();
  ASSERT_EQ(vanishing.cols(), 1);
  ASSERT_EQ(free.cols(), 4);
  EXPECT_LT((Phi.transpose() * vanishing).norm(), 1e-14);
  EXPECT_LT((Phi * free).norm(), 1e-14);
  EXPECT_NEAR(vanishing.norm(), 1.0, 1e-14);
  EXPECT_LT((free.transpose() * free - MatX::Identity(4, 4)).norm(), 1e-14);
  EXPECT_EQ(RowRank(MatX(3, 0)).vanishing_combinations(0), MatX::Identity(3, 3));
  EXPECT_EQ(RowRank(MatX(0, 3)).free_directions(), MatX::Identity(3, 3));
}

/// In parts of the largest row, or of 1, the size of a row.
TEST(RowRank, KnowsAPoseBesideASingularOne) {
  for (const double size : {1.0, 1e3}) {
    for (const double part : {1e-7, 1e-4}) {
      MatX Phi = size * random_rows(4, 6, 31);
      Phi.row(2) = 0.5 * Phi.row(0) + part * Phi.row(2);
      EXPECT_EQ(RowRank(Phi).rank(), 4);
      EXPECT_EQ(RowRank(Phi).is_beside_singular(), part < 1e-5) << size;
    }
  }
}

TEST(RowRank, OfNothingAreRegularAndOfTooFewColumnsAreNot) {
  RowRank factors(MatX(0, 5));
  EXPECT_EQ(factors.rank(), 0);
  EXPECT_EQ(factors.singular_value(0), 1.0);
  EXPECT_EQ(factors.smallest_step(VecX(0)), VecX::Zero(5));
  factors.compute(random_rows(3, 2, 9));
  EXPECT_EQ(factors.rank(), 2);
  EXPECT_EQ(factors.singular_value(3), 0.0);
}

}  // namespace
}  // namespace concord::relative
