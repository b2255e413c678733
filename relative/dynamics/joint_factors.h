#pragma once

#include "common/types.h"
#include "relative/bodies/small_products.h"

/// Small triangles and columns of six rows, by loops of fixed length over vectors of six. Eigen's own products and
/// triangular solvers of each size unroll by templates, which took most of the time that the passes need to compile.
/// Each sum keeps the order that these have. All are inlined by force, as Eigen's would be.
namespace concord::relative {

/// Pivots below this part of the terms they are made of are round-off.
inline constexpr double kRoundOffOfPivot = 1e-13;

/// Factors L diag(d) L^T of the symmetric N x N matrix in D (lower triangle read), with ones on the diagonal of L: L
/// below the diagonal of D, d on it. False if D is not positive definite. Without roots, what a matrix of one number
/// divides by itself is one, to the last bit.
template <int N>
[[gnu::always_inline]] inline bool factorize(Mat6& D) {
#pragma GCC unroll 6
  for (int j = 0; j < N; ++j) {
    double pivot = D(j, j);
#pragma GCC unroll 6
    for (int k = 0; k < j; ++k) pivot -= D(j, k) * (D(j, k) * D(k, k));
    if (!(pivot > kRoundOffOfPivot * D(j, j))) return false;
    D(j, j) = pivot;
#pragma GCC unroll 6
    for (int i = j + 1; i < N; ++i) {
      double entry = D(i, j);
#pragma GCC unroll 6
      for (int k = 0; k < j; ++k) entry -= D(i, k) * (D(j, k) * D(k, k));
      D(i, j) = entry / pivot;
    }
  }
  return true;
}

/// L^-1 x in place of the first N numbers of x, L lower triangular with ones on its diagonal.
template <int N, class Vector>
[[gnu::always_inline]] inline void substitute_forward(const Mat6& L, Vector& x) {
#pragma GCC unroll 6
  for (int i = 1; i < N; ++i) {
#pragma GCC unroll 6
    for (int k = 0; k < i; ++k) x(i) -= L(i, k) * x(k);
  }
}

/// L^-T x in place of x.
template <int N, class Vector>
[[gnu::always_inline]] inline void substitute_backward(const Mat6& L, Vector& x) {
#pragma GCC unroll 6
  for (int i = N - 2; i >= 0; --i) {
#pragma GCC unroll 6
    for (int k = i + 1; k < N; ++k) x(i) -= L(k, i) * x(k);
  }
}

/// U L^-T in place of the first N columns of U.
template <int N>
[[gnu::always_inline]] inline void divide_by_transpose(const Mat6& L, Mat6& U) {
#pragma GCC unroll 6
  for (int i = 1; i < N; ++i) {
#pragma GCC unroll 6
    for (int k = 0; k < i; ++k) U.col(i) -= L(i, k) * U.col(k);
  }
}

/// Scalar product with a column of six rows; the first three rows of the column vanish where a joint only turns about
/// the reference point of a rigid body.
template <bool kOnlyTurns>
[[gnu::always_inline]] inline double scalar_product(const double* column, const Vec6& other) {
  if constexpr (kOnlyTurns) return column[3] * other(3) + column[4] * other(4) + column[5] * other(5);
  return Eigen::Map<const Vec6>(column).dot(other);
}

/// Adds I c to a vector and writes I h, where each pair of rows of I is read once.
template <bool kOnlyTurns>
[[gnu::always_inline]] inline void multiply_both(const Mat6& I, const Vec6& c, const double* h, Vec6& sum, double* Ih) {
  const auto two_rows = [&](int row) {
    const double* m = I.data() + row;
    const Pair columns[6] = {load_pair(m),      load_pair(m + 6),  load_pair(m + 12),
                             load_pair(m + 18), load_pair(m + 24), load_pair(m + 30)};
    const Pair along_c = columns[0] * c(0) + columns[1] * c(1) + columns[2] * c(2) + columns[3] * c(3) +
                         columns[4] * c(4) + columns[5] * c(5);
    store_pair(load_pair(sum.data() + row) + along_c, sum.data() + row);
    if constexpr (kOnlyTurns) {
      store_pair(columns[3] * h[3] + columns[4] * h[4] + columns[5] * h[5], Ih + row);
    } else {
      store_pair(columns[0] * h[0] + columns[1] * h[1] + columns[2] * h[2] + columns[3] * h[3] + columns[4] * h[4] +
                     columns[5] * h[5],
                 Ih + row);
    }
  };
  two_rows(0);
  two_rows(2);
  two_rows(4);
}

/// The first N columns times as many factors, summed up.
template <int N, class Factors>
[[gnu::always_inline]] inline Vec6 combination(const Mat6& columns, const Factors& factors) {
  Vec6 sum = columns.col(0) * factors(0);
#pragma GCC unroll 6
  for (int k = 1; k < N; ++k) sum += columns.col(k) * factors(k);
  return sum;
}

/// I - V W^T, of the first N columns of V and W, into the upper triangle of another matrix: it is symmetric.
template <int N>
[[gnu::always_inline]] inline void take_off_products(const Mat6& I, const Mat6& V, const Mat6& W, Mat6& rest) {
  const auto two_rows = [&](int row, int column) {
    Pair sum = load_pair(V.data() + row) * W(column, 0);
#pragma GCC unroll 6
    for (int k = 1; k < N; ++k) sum += load_pair(V.data() + 6 * k + row) * W(column, k);
    store_pair(load_pair(I.data() + 6 * column + row) - sum, rest.data() + 6 * column + row);
  };
  two_rows(0, 0);
  two_rows(0, 1);
  two_rows(0, 2);
  two_rows(2, 2);
  two_rows(0, 3);
  two_rows(2, 3);
  two_rows(0, 4);
  two_rows(2, 4);
  two_rows(4, 4);
  two_rows(0, 5);
  two_rows(2, 5);
  two_rows(4, 5);
}

/// Adds Sh(rho)^T I Sh(rho) to a sum, of a symmetric I whose upper triangle is read. With I = [A, B; B^T, C] it is
/// [A, B'; B'^T, C'], where B' = B - A rho~ and C' = C - B^T rho~ - (B'^T rho~)^T; a row x^T times rho~ is
/// (x cross rho)^T. By pairs of rows, and the third.
[[gnu::always_inline]] inline void add_shifted(const Mat6& I, const Vec3& rho, Mat6& sum) {
  const double x = rho.x();
  const double y = rho.y();
  const double z = rho.z();
  const double* a = I.data();
  double* s = sum.data();
  const auto add_column = [](const Pair& first, const Pair& second, const Pair& third, double* to) {
    store_pair(load_pair(to) + first, to);
    store_pair(load_pair(to + 2) + second, to + 2);
    store_pair(load_pair(to + 4) + third, to + 4);
  };
  const Pair A0{a[0], a[6]};
  const Pair A1 = load_pair(a + 6);
  const Pair A2 = load_pair(a + 12);
  const Pair upper_B0 = load_pair(a + 18);
  const Pair upper_B1 = load_pair(a + 24);
  const Pair upper_B2 = load_pair(a + 30);
  const Pair B0 = upper_B0 - (A1 * z - A2 * y);
  const Pair B1 = upper_B1 - (A2 * x - A0 * z);
  const Pair B2 = upper_B2 - (A0 * y - A1 * x);
  const double b0 = a[20] - (A2[1] * z - a[14] * y);
  const double b1 = a[26] - (a[14] * x - A2[0] * z);
  const double b2 = a[32] - (A2[0] * y - A2[1] * x);
  // Rows of B, as B^T has them.
  const Pair r0{upper_B0[0], upper_B1[0]};
  const Pair r1{upper_B0[1], upper_B1[1]};
  const Pair r2{a[20], a[26]};
  const Pair zx{z, x};
  const Pair yz{y, z};
  const double first = a[21] - (r1[0] * z - r2[0] * y) - (B0[1] * z - b0 * y);
  const Pair C1 = load_pair(a + 27) - (r2 * x - r0 * z) - (Pair{B1[1], b1} * zx - Pair{b1, B1[0]} * yz);
  const double c0 = a[33] - (a[31] * z - a[32] * y) - (B0[0] * y - B0[1] * x);
  const double c1 = a[34] - (a[32] * x - a[30] * z) - (B1[0] * y - B1[1] * x);
  const double last = a[35] - (a[30] * y - a[31] * x) - (B2[0] * y - B2[1] * x);
  add_column(A0, Pair{A2[0], B0[0]}, Pair{B1[0], B2[0]}, s);
  add_column(A1, Pair{A2[1], B0[1]}, Pair{B1[1], B2[1]}, s + 6);
  add_column(A2, Pair{a[14], b0}, Pair{b1, b2}, s + 12);
  add_column(B0, Pair{b0, first}, Pair{C1[0], c0}, s + 18);
  add_column(B1, Pair{b1, C1[0]}, Pair{C1[1], c1}, s + 24);
  add_column(B2, Pair{b2, c0}, Pair{c1, last}, s + 30);
}

/// Calls f with the number of free speeds, 1 to 6, as a constant of type std::integral_constant.
template <class F>
[[gnu::always_inline]] inline void with_constant(int n, const F& f) {
  switch (n) {
    case 1:
      return f(std::integral_constant<int, 1>());
    case 2:
      return f(std::integral_constant<int, 2>());
    case 3:
      return f(std::integral_constant<int, 3>());
    case 4:
      return f(std::integral_constant<int, 4>());
    case 5:
      return f(std::integral_constant<int, 5>());
    default:
      return f(std::integral_constant<int, 6>());
  }
}

}  // namespace concord::relative
