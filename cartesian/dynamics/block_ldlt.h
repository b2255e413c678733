#pragma once

#include <utility>
#include <vector>

#include "common/types.h"

namespace concord::cartesian {

/// The first so many rows and columns of A = L D L^T in place, of whose lower triangle alone is read: L below its unit
/// diagonal, and the inverse of D. Where L has none, what stands in A afterwards means nothing. Without roots, units
/// that are powers of two leave every digit. False if a pivot is not above its entry of `least`.
[[nodiscard]] bool factor_block(Mat6& A, Vec6& inverse_D, const Vec6& least, int size = 6);
/// L^-1 x and L^-T x in place.
void solve_lower(const Mat6& L, Vec6& x);
void solve_upper(const Mat6& L, Vec6& x);

/// to += sign left diag(weights) right^T, of whose columns the first so many, over the first so many terms.
template <int sign, class Left, class Weights, class Right, class To>
void add_product(const Left& left, const Weights& weights, const Right& right, To&& to, int columns, int terms) {
  for (int c = 0; c < columns; ++c) {
    Vec6 column = to.col(c);
    for (int k = 0; k < terms; ++k) column += (sign * weights(k) * right(c, k)) * left.col(k);
    to.col(c) = column;
  }
}

/// X L^-T in place, the first so many columns.
template <class Lower, class Rows>
void divide_rows(const Lower& L, Rows&& X, int columns) {
  for (Eigen::Index c = 1; c < columns; ++c) {
    Vec6 column = X.col(c);
    for (Eigen::Index k = 0; k < c; ++k) column -= L(c, k) * X.col(k);
    X.col(c) = column;
  }
}

/// Symmetric positive definite matrix of blocks of at most 6 x 6 in a frozen pattern, and its factors L D L^T in the
/// order of its block rows: the fill is decided once, numbers as often as they change. A chain is block tridiagonal and
/// has no fill (C66). What a block has beyond its rows and columns stays zero.
class BlockLdlt {
 public:
  using Pair = std::pair<int, int>;

  BlockLdlt() = default;
  /// With so many rows in each block row, 6 at most, of which these pairs have a block (either way round; those on the
  /// diagonal all have one).
  BlockLdlt(std::vector<int> sizes, const std::vector<Pair>& pairs);

  [[nodiscard]] int size() const { return static_cast<int>(sizes_.size()); }
  /// Place of the block of a row and a column, row >= column, which must be in the pattern.
  [[nodiscard]] int find(int row, int column) const;
  [[nodiscard]] Mat6& block(int place) { return blocks_[place]; }
  void set_zero();

  /// Factorizes in place. False if a pivot is not above `least` of what stood in its place before elimination.
  [[nodiscard]] bool factor(double least);
  /// Solves in place, a column for each block row.
  void solve(Mat6X& x) const;

 private:
  struct Below {  // a block below the diagonal
    int row;
    int place;
  };
  struct Update {  // target -= left D^-1 right^T, left and right L D
    int target;
    int left;
    int right;
    int columns;  // of the target
  };

  std::vector<int> sizes_;
  std::vector<std::vector<Below>> below_;     // by column, rows ascending
  std::vector<std::vector<Update>> updates_;  // by column, what its elimination changes
  std::vector<Mat6, Eigen::aligned_allocator<Mat6>> blocks_;
  std::vector<Vec6, Eigen::aligned_allocator<Vec6>> inverse_D_;
  std::vector<Vec6, Eigen::aligned_allocator<Vec6>> least_;
};

/// An order of little fill of n block rows of which these pairs have a block: the k-th to be eliminated.
std::vector<int> elimination_order(int n, const std::vector<BlockLdlt::Pair>& pairs);

}  // namespace concord::cartesian
