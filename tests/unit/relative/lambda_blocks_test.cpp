#include "relative/dynamics/lambda_blocks.h"

#include <gtest/gtest.h>

#include "machines.h"

namespace concord::relative {
namespace {

using Neighbours = std::vector<std::set<int>>;

std::vector<RowGroup> groups_of(const std::vector<int>& sizes) {
  std::vector<RowGroup> groups;
  int first = 0;
  for (const int size : sizes) {
    groups.push_back({first, size});
    first += size;
  }
  return groups;
}

/// Couples each pair of neighbours that is told, both ways.
Neighbours coupled(std::size_t n, const std::vector<std::pair<int, int>>& pairs) {
  Neighbours neighbours(n);
  for (const auto& [a, b] : pairs) {
    neighbours[a].insert(b);
    neighbours[b].insert(a);
  }
  return neighbours;
}

/// Lambda = E^T E of random responses E: some rows for each group alone, some for each pair that couples. Writes its
/// blocks, and returns all of it.
MatX fill(LambdaBlocks& blocks, const std::vector<std::pair<int, int>>& pairs, test::Numbers& numbers) {
  const std::vector<RowGroup>& groups = blocks.order().groups();
  const auto n = static_cast<int>(groups.size());
  std::vector<std::pair<int, int>> links = pairs;
  for (int group = 0; group < n; ++group) links.emplace_back(group, group);
  constexpr int kUnknowns = 7;
  MatX E = MatX::Zero(kUnknowns * static_cast<Eigen::Index>(links.size()), blocks.n_rows());
  for (std::size_t l = 0; l < links.size(); ++l) {
    for (const int group : {links[l].first, links[l].second}) {
      for (int row = 0; row < groups[group].n_rows; ++row) {
        E.block<kUnknowns, 1>(kUnknowns * static_cast<Eigen::Index>(l), groups[group].first_row + row) =
            numbers.vector(kUnknowns, 1.0);
      }
    }
  }
  const MatX product = E.transpose() * E;
  const MatX Lambda = 0.5 * (product + product.transpose());
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < n; ++b) {
      const int block = blocks.order().block_of(a, b);
      if (block < 0 || blocks.order().place_of(a) < blocks.order().place_of(b)) continue;
      double* entry = blocks.values(block);
      for (int r = 0; r < groups[a].n_rows; ++r) {
        for (int c = 0; c < groups[b].n_rows; ++c) *entry++ = Lambda(groups[a].first_row + r, groups[b].first_row + c);
      }
    }
  }
  return Lambda;
}

struct Pattern {
  const char* name;
  std::vector<int> sizes;
  std::vector<std::pair<int, int>> pairs;
  std::size_t blocks;  // of the factor: groups, pairs and what elimination fills
};

class Lambda : public ::testing::TestWithParam<Pattern> {};

/// Over all rows, and over rows that leave out some, a group as a whole among them, as where rows are redundant.
TEST_P(Lambda, IsSolvedByBlocksAsByADenseFactor) {
  test::Numbers numbers(11);
  const Pattern& pattern = GetParam();
  LambdaBlocks blocks({groups_of(pattern.sizes), coupled(pattern.sizes.size(), pattern.pairs)});
  EXPECT_EQ(blocks.order().blocks().size(), pattern.blocks);
  BlockCholesky factor(blocks);
  const MatX dense = fill(blocks, pattern.pairs, numbers);
  MatX written = MatX::Zero(dense.rows(), dense.cols());
  blocks.write_dense(written);
  EXPECT_EQ(written, dense);
  for (const int left_out : {0, 3, 0, 2}) {
    IndependentRows rows(dense.rows());
    VecX diagonal = VecX::Zero(dense.rows());
    blocks.write_diagonal(diagonal);
    scale_rows(diagonal, VecX::Ones(dense.rows()), rows);
    for (int row = 0; row < static_cast<int>(dense.rows()); ++row) {
      if (left_out == 0 || (row % left_out != 0 && row >= pattern.sizes[0])) rows.rows.emplace_back(row);
    }
    const auto n = static_cast<Eigen::Index>(rows.rows.size());
    MatX chosen(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < n; ++j) {
        const int row = rows.rows[i];
        const int column = rows.rows[j];
        chosen(i, j) = rows.scale(row) * dense(row, column) * rows.scale(column);
      }
    }
    const double pivot = factor.factor(rows);
    EXPECT_GT(pivot, 1e-6);
    EXPECT_LE(pivot, 1.0);
    const VecX right = numbers.vector(n, 1.0);
    VecX found = right;
    factor.solve(found);
    EXPECT_LT((chosen * found - right).norm(), 1e-12 * found.norm()) << left_out;
  }
}

TEST_P(Lambda, OfDependentRowsHasNoPivot) {
  test::Numbers numbers(12);
  const Pattern& pattern = GetParam();
  LambdaBlocks blocks({groups_of(pattern.sizes), coupled(pattern.sizes.size(), pattern.pairs)});
  BlockCholesky factor(blocks);
  const MatX dense = fill(blocks, pattern.pairs, numbers);
  IndependentRows rows(dense.rows());
  scale_rows(dense.diagonal(), VecX::Ones(dense.rows()), rows);
  for (int row = 0; row < static_cast<int>(dense.rows()); ++row) rows.rows.emplace_back(row);
  // The second row of the second group as the first one says it.
  const int diagonal = blocks.order().diagonal(blocks.order().place_of(1));
  const int first = blocks.order().groups()[1].first_row;
  double* entry = blocks.values(diagonal);
  entry[blocks.n_columns(diagonal)] = entry[1] = 1.0 / (rows.scale(first) * rows.scale(first + 1));
  EXPECT_LT(factor.factor(rows), 1e-14);
}

INSTANTIATE_TEST_SUITE_P(
    Patterns, Lambda,
    ::testing::Values(Pattern{"ladder", {3, 2, 3, 5, 1, 3}, {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}}, 11},
                      Pattern{"tree", {4, 2, 3, 1, 3, 2, 6}, {{0, 1}, {0, 2}, {1, 3}, {1, 4}, {2, 5}, {2, 6}}, 13},
                      Pattern{"star", {2, 3, 5, 1}, {{0, 1}, {0, 2}, {0, 3}}, 7},
                      Pattern{"ring", {3, 3, 2, 4, 3}, {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 0}}, 12},
                      Pattern{"all", {3, 2, 4, 6}, {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}, 10},
                      Pattern{"apart", {5, 2, 3}, {}, 3}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace concord::relative
