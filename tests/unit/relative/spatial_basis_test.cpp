#include "relative/bodies/spatial_basis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/decompositions.h"

namespace concord::relative {
namespace {

constexpr double kRoundOff = 1e-14;

class SpatialBases : public testing::TestWithParam<int> {
 protected:
  Mat3 draw_columns() {
    Mat3 columns;
    for (int row = 0; row < 3; ++row) {
      for (int c = 0; c < 3; ++c) columns(row, c) = spread_(random_);
    }
    return columns;
  }
  Vec3 draw_vector() { return draw_columns().col(0); }

 private:
  std::mt19937 random_{7};
  std::uniform_real_distribution<double> spread_{-1.0, 1.0};
};

TEST_P(SpatialBases, FitAsLeastSquaresDo) {
  const int n = GetParam();
  for (int pose = 0; pose < 20; ++pose) {
    const Mat3 columns = draw_columns();
    const Vec3 v = draw_vector();
    SpatialBasis basis;
    basis.decompose(columns, n);
    Vec3 expected = Vec3::Zero();
    expected.head(n) = least_squares(columns.leftCols(n), v);
    EXPECT_LT((basis.fit(v) - expected).norm(), 100.0 * kRoundOff * (1.0 + expected.norm()));
  }
}

TEST_P(SpatialBases, CompleteThemselvesAtRightAngles) {
  const int n = GetParam();
  for (int pose = 0; pose < 20; ++pose) {
    const Mat3 columns = draw_columns();
    SpatialBasis basis;
    basis.decompose(columns, n);
    const Mat3X rest = basis.complement();
    ASSERT_EQ(rest.cols(), 3 - n);
    EXPECT_LT((rest.transpose() * columns.leftCols(n)).norm(), kRoundOff);
    EXPECT_LT((rest.transpose() * rest - MatX::Identity(3 - n, 3 - n)).norm(), kRoundOff);
  }
}

TEST_P(SpatialBases, TellWhatTheLastColumnKeeps) {
  const int n = GetParam();
  for (int pose = 0; pose < 20; ++pose) {
    const Mat3 columns = draw_columns();
    const Eigen::ColPivHouseholderQR<Mat3X> qr(columns.leftCols(n));
    EXPECT_NEAR(least_independent_part(columns, n), std::abs(qr.matrixQR()(n - 1, n - 1)), kRoundOff);
  }
}

INSTANTIATE_TEST_SUITE_P(OfColumns, SpatialBases, testing::Values(1, 2, 3));

TEST(SpatialBasis, OfNoColumnsIsSpace) {
  SpatialBasis basis;
  basis.decompose(Mat3::Random(), 0);
  EXPECT_EQ(basis.complement().cols(), 3);
  EXPECT_EQ(basis.fit(Vec3(1, 2, 3)).norm(), 0.0);
  EXPECT_TRUE(std::isinf(least_independent_part(Mat3::Zero(), 0)));
}

TEST(SpatialBasis, FitsNearlyParallelColumnsToTheAccuracyTheyHave) {
  Mat3 columns;
  columns << 1.0, 1.0, 0.3, 2.0, 2.0, -0.4, -0.5, -0.5 + 1e-5, 0.9;
  const Vec3 expected(0.7, -1.3, 2.1);
  SpatialBasis basis;
  basis.decompose(columns, 3);
  EXPECT_LT((basis.fit(columns * expected) - expected).norm(), 1e-10);  // normal equations would lose twice as much
}

TEST(SpatialBasis, GivesADependentColumnNoPart) {
  Mat3 columns;
  columns << 0.3, -0.6, 0.2, 0.5, -1.0, 0.1, -0.2, 0.4, 0.7;
  SpatialBasis basis;
  basis.decompose(columns, 3);
  const Vec3 v = 2.0 * columns.col(0) - 0.5 * columns.col(2);
  EXPECT_LT((basis.fit(v) - Vec3(2.0, 0.0, -0.5)).norm(), 10.0 * kRoundOff);
  EXPECT_LT(least_independent_part(columns, 3), kRoundOff);
  EXPECT_LT(least_independent_part(columns, 2), kRoundOff);
  columns.col(0).setZero();
  basis.decompose(columns, 1);
  EXPECT_EQ(basis.fit(v).norm(), 0.0);
  EXPECT_EQ(least_independent_part(columns, 1), 0.0);
}

}  // namespace
}  // namespace concord::relative
