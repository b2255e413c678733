#include "common/decompositions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>

namespace concord {
namespace {

/// Orthogonal matrices from the QR of numbers without pattern.
MatX orthogonal(Eigen::Index size, double seed) {
  const MatX numbers =
      MatX::NullaryExpr(size, size, [&](Eigen::Index i, Eigen::Index j) { return std::sin(seed + 3.7 * i * j + i); });
  return Eigen::HouseholderQR<MatX>(numbers).householderQ();
}

void expect_to_give_back(const MatX& A) {
  const Svd svd = svd_of(A);
  MatX sigma = MatX::Zero(A.rows(), A.cols());
  sigma.diagonal() = svd.sigma;
  EXPECT_LT((svd.U * sigma * svd.V.transpose() - A).norm(), 1e-12) << A.rows() << " x " << A.cols();
  EXPECT_LT((svd.U.transpose() * svd.U - MatX::Identity(A.rows(), A.rows())).norm(), 1e-12);
  EXPECT_LT((svd.V.transpose() * svd.V - MatX::Identity(A.cols(), A.cols())).norm(), 1e-12);
}

TEST(Decompositions, SingularVectorsGiveTheMatrixBackThoughValuesAreEqual) {
  for (const auto& [rows, columns] : {std::pair{5, 3}, {3, 5}, {60, 41}, {41, 60}}) {
    for (const int distinct : {1, 4, 1000}) {
      const auto n = std::min(rows, columns);
      MatX sigma = MatX::Zero(rows, columns);
      for (int k = 0; k < n - 2; ++k) sigma(k, k) = 2.0 - (k % distinct) / double(distinct + n);
      expect_to_give_back(orthogonal(rows, 0.3) * sigma * orthogonal(columns, 1.1));
    }
  }
}

TEST(Decompositions, EigenpairsOfAGeneralMatrixHaveLengthOneAndSatisfyIt) {
  for (const Eigen::Index size : {1, 4, 7}) {
    // In units that differ by so much that only balancing finds the small ones.
    const VecX units = VecX::NullaryExpr(size, [](Eigen::Index i) { return std::pow(100.0, double(i)); });
    const MatX balanced = MatX::NullaryExpr(size, size, [](Eigen::Index i, Eigen::Index j) {
      return std::sin(1.0 + 2.3 * double(i) + 5.1 * double(i * j));
    });
    const MatX A = units.asDiagonal() * balanced * units.cwiseInverse().asDiagonal();
    const GeneralEigenpairs pairs = eigenpairs(A);
    const Eigen::MatrixXcd complex = balanced.cast<std::complex<double>>();
    for (Eigen::Index k = 0; k < size; ++k) {
      const Eigen::VectorXcd vector = pairs.vectors.col(k);
      EXPECT_NEAR(vector.norm(), 1.0, 1e-14);
      const Eigen::VectorXcd in_units = vector.cwiseQuotient(units.cast<std::complex<double>>());
      EXPECT_LT((complex * in_units - pairs.values(k) * in_units).norm(), 1e-12 * in_units.norm()) << size;
    }
    EXPECT_LT(std::abs(pairs.values.sum() - A.trace()), 1e-12);
  }
  const GeneralEigenpairs turning = eigenpairs(MatX{{0.0, -2.0}, {2.0, 0.0}});
  EXPECT_LT(std::abs(turning.values(0) - std::complex<double>(0.0, 2.0)), 1e-15);
  EXPECT_LT(std::abs(turning.values(1) - std::complex<double>(0.0, -2.0)), 1e-15);
}

/// LAPACK ends the program on empty matrices, and may not end on numbers that are not finite.
TEST(Decompositions, OfNothingAndOfWhatIsNotFinite) {
  EXPECT_EQ(eigenpairs(MatX(0, 0)).values.size(), 0);
  EXPECT_EQ(svd_of(MatX(3, 0)).U.cols(), 3);
  for (const double odd : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    MatX A = MatX::Identity(3, 3);
    A(1, 2) = odd;
    EXPECT_TRUE(eigenpairs(A).values.array().isNaN().all());
    EXPECT_TRUE(svd_of(A).sigma.array().isNaN().all());
    EXPECT_EQ(svd_of(A).V.cols(), 3);
  }
}

TEST(Decompositions, InverseOfAComplexMatrixMultipliesToOne) {
  const Eigen::MatrixXcd A = orthogonal(4, 0.7) + std::complex<double>(0.0, 0.5) * orthogonal(4, 2.3);
  EXPECT_LT((inverse_of(A) * A - Eigen::MatrixXcd::Identity(4, 4)).norm(), 1e-13);
  Eigen::MatrixXcd singular = A;
  singular.col(2).setZero();
  EXPECT_FALSE(inverse_of(singular).allFinite());
  EXPECT_FALSE(inverse_of(A / 0.0).allFinite());
  EXPECT_EQ(inverse_of(Eigen::MatrixXcd(0, 0)).size(), 0);
}

}  // namespace
TEST(Decompositions, SingularValuesOfNothingAreNone) {
  EXPECT_EQ(singular_values(MatX(3, 0)).size(), 0);
  EXPECT_EQ(singular_values(MatX(0, 2)).size(), 0);
}

}  // namespace concord
