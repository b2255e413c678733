#pragma once

#include <utility>
#include <vector>

#include "cartesian/bodies/small_products.h"
#include "common/types.h"

namespace concord::cartesian {

// Loops over at most six rows and columns are unrolled by order: g++ leaves them as they are at -O2.

/// The first N rows and columns of A = L D L^T in place, of whose lower triangle alone is read: L below its unit
/// diagonal, and the inverse of D. Where L has none, what stands in A afterwards means nothing. Without roots, units
/// that are powers of two leave every digit. False if a pivot is not above its entry of `least`.
template <int N>
[[nodiscard]] bool factor_block(Mat6& A, Vec6& inverse_D, const Vec6& least) {
  bool is_positive = true;
#pragma GCC unroll 6
  for (int c = 0; c < N; ++c) {
    is_positive = is_positive && A(c, c) > least(c);
    const double inverse = 1.0 / A(c, c);
    inverse_D(c) = inverse;
    const Vec6 column = A.col(c);
    A.col(c) = inverse * column;
#pragma GCC unroll 6
    for (int later = c + 1; later < N; ++later) A.col(later) -= (inverse * column(later)) * column;
  }
  return is_positive;
}

/// L^-1 x and L^-T x in place.
[[gnu::always_inline]] inline void solve_lower(const Mat6& L, Vec6& x) {
  Pair pairs[3] = {load_pair(x.data()), load_pair(x.data() + 2), load_pair(x.data() + 4)};
#pragma GCC unroll 3
  for (int own = 0; own < 3; ++own) {
    const double* column = L.col(2 * own).data();
    const double first = pairs[own][0];
    const double second = pairs[own][1] - column[2 * own + 1] * first;
    pairs[own] = Pair{first, second};
#pragma GCC unroll 3
    for (int later = own + 1; later < 3; ++later) {
      pairs[later] -= load_pair(column + 2 * later) * first + load_pair(column + 6 + 2 * later) * second;
    }
    store_pair(pairs[own], x.data() + 2 * own);
  }
}
[[gnu::always_inline]] inline void solve_upper(const Mat6& L, Vec6& x) {
  Pair pairs[3] = {load_pair(x.data()), load_pair(x.data() + 2), load_pair(x.data() + 4)};
#pragma GCC unroll 3
  for (int own = 2; own >= 0; --own) {
    const int row = 2 * own;
    const double second = pairs[own][1];
    const double first = pairs[own][0] - L(row + 1, row) * second;
    pairs[own] = Pair{first, second};
#pragma GCC unroll 3
    for (int before = 0; before < own; ++before) {
      const double* column = L.col(2 * before).data();
      pairs[before] -= Pair{column[row], column[6 + row]} * first + Pair{column[row + 1], column[7 + row]} * second;
    }
    store_pair(pairs[own], x.data() + row);
  }
}

/// to += sign left diag(weights) right^T, of whose columns the first so many, over the first N terms.
template <int sign, int N, class Left, class Right>
void add_product(const Left& left, const Vec6& weights, const Right& right, Mat6& to, int columns) {
  for (int c = 0; c < columns; ++c) {
    Vec6 column = to.col(c);
#pragma GCC unroll 6
    for (int k = 0; k < N; ++k) column += (sign * weights(k) * right(c, k)) * left.col(k);
    to.col(c) = column;
  }
}
/// The same over so many terms as are known only to a machine.
template <int sign, class Left, class Right, class To>
void add_product(const Left& left, const VecX& weights, const Right& right, To&& to, int columns) {
  for (int c = 0; c < columns; ++c) {
    Vec6 column = to.col(c);
    for (Eigen::Index k = 0; k < weights.size(); ++k) column += (sign * weights(k) * right(c, k)) * left.col(k);
    to.col(c) = column;
  }
}

/// X L^-T in place, the first N columns.
template <int N, class Rows>
void divide_rows(const Mat6& L, Rows&& X) {
#pragma GCC unroll 6
  for (int c = 1; c < N; ++c) {
    Vec6 column = X.col(c);
#pragma GCC unroll 6
    for (int k = 0; k < c; ++k) column -= L(c, k) * X.col(k);
    X.col(c) = column;
  }
}
/// The same of all columns.
template <class Rows>
void divide_rows(const MatX& L, Rows&& X) {
  for (Eigen::Index c = 1; c < X.cols(); ++c) {
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
  using Coupled = std::pair<int, int>;

  BlockLdlt() = default;
  /// With so many rows in each block row, 6 at most, of which these pairs have a block (either way round; those on the
  /// diagonal all have one).
  BlockLdlt(std::vector<int> sizes, const std::vector<Coupled>& pairs);

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
  [[nodiscard]] bool eliminate(int column);
  template <int N>
  [[nodiscard]] bool eliminate(int column);

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
std::vector<int> elimination_order(int n, const std::vector<BlockLdlt::Coupled>& pairs);

}  // namespace concord::cartesian
