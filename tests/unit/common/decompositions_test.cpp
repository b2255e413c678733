#include "common/decompositions.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace concord
