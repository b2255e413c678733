#include "cartesian/dynamics/block_ldlt.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <stdexcept>
#include <vector>

#include "machines.h"

namespace concord::cartesian {
namespace {

using testing::Numbers;

/// Of each block row.
const std::vector<int> kSizes = {6, 3, 5, 1, 6, 4, 2};
constexpr int kBlocks = 7;

/// A ring with two chords, in an order that fills.
const std::vector<BlockLdlt::Coupled> kPairs = {{0, 3}, {3, 6}, {6, 1}, {1, 4}, {4, 2}, {2, 5}, {5, 0}, {0, 1}, {2, 6}};

class Assembled {
 public:
  explicit Assembled(double least_eigenvalue) : factors_(kSizes, kPairs), dense_(6 * kBlocks, 6 * kBlocks) {
    Numbers numbers(17);
    dense_.setZero();
    for (const auto& [one, other] : kPairs) {
      MatX root = numbers.matrix(12, 2);
      root.middleRows(kSizes[one], 6 - kSizes[one]).setZero();
      root.bottomRows(6 - kSizes[other]).setZero();
      add(one, one, root.topRows(6) * root.topRows(6).transpose());
      add(other, other, root.bottomRows(6) * root.bottomRows(6).transpose());
      add(std::max(one, other), std::min(one, other),
          one > other ? MatX(root.topRows(6) * root.bottomRows(6).transpose())
                      : MatX(root.bottomRows(6) * root.topRows(6).transpose()));
    }
    for (int k = 0; k < kBlocks; ++k) {
      const int size = kSizes[k];
      MatX own = MatX::Zero(6, 6);
      own.topLeftCorner(size, size) = least_eigenvalue * MatX::Identity(size, size);
      add(k, k, own);
      dense_.block(6 * k, 6 * k, 6, 6).diagonal().tail(6 - size).setOnes();
    }
  }

  BlockLdlt factors_;
  MatX dense_;

 private:
  void add(int row, int column, const MatX& block) {
    factors_.block(factors_.find(row, column)) += block;
    dense_.block<6, 6>(6 * row, 6 * column) += block;
    if (row != column) dense_.block<6, 6>(6 * column, 6 * row) += block.transpose();
  }
};

TEST(BlockLdlt, SolvesAsADenseFactorizationDoes) {
  Assembled matrix(0.5);
  ASSERT_TRUE(matrix.factors_.factor(1e-9));
  Mat6X x = Numbers(18).matrix(6, kBlocks);
  for (int k = 0; k < kBlocks; ++k) x.col(k).tail(6 - kSizes[k]).setZero();
  const VecX exact = matrix.dense_.ldlt().solve(VecX(x.reshaped()));
  matrix.factors_.solve(x);
  EXPECT_LT((x.reshaped() - exact).norm(), 1e-12 * exact.norm());
}

TEST(BlockLdlt, TellsAMatrixThatIsNotPositive) {
  EXPECT_FALSE(Assembled(0.0).factors_.factor(1e-9));
  EXPECT_FALSE(Assembled(-0.5).factors_.factor(1e-9));
}

TEST(BlockLdlt, AChainHasNoFill) {
  const std::vector<BlockLdlt::Coupled> pairs = {{0, 1}, {2, 1}, {2, 3}};
  const BlockLdlt chain({5, 5, 5, 5}, pairs);
  EXPECT_NO_THROW((void)chain.find(2, 1));
  EXPECT_THROW((void)chain.find(2, 0), std::logic_error);
  EXPECT_THROW((void)chain.find(3, 1), std::logic_error);
}

/// A star's middle goes last.
TEST(BlockLdlt, TheOrderKeepsFillLow) {
  const std::vector<BlockLdlt::Coupled> star = {{0, 1}, {0, 2}, {0, 3}, {0, 4}};
  const std::vector<int> order = elimination_order(5, star);
  EXPECT_TRUE(order[4] == 0 || order[3] == 0);
}

}  // namespace
}  // namespace concord::cartesian
