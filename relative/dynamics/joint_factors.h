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
  for (int j = 0; j < N; ++j) {
    double pivot = D(j, j);
    for (int k = 0; k < j; ++k) pivot -= D(j, k) * (D(j, k) * D(k, k));
    if (!(pivot > kRoundOffOfPivot * D(j, j))) return false;
    D(j, j) = pivot;
    for (int i = j + 1; i < N; ++i) {
      double entry = D(i, j);
      for (int k = 0; k < j; ++k) entry -= D(i, k) * (D(j, k) * D(k, k));
      D(i, j) = entry / pivot;
    }
  }
  return true;
}

/// L^-1 x in place of the first N numbers of x, L lower triangular with ones on its diagonal.
template <int N, class Vector>
[[gnu::always_inline]] inline void substitute_forward(const Mat6& L, Vector& x) {
  for (int i = 1; i < N; ++i) {
    for (int k = 0; k < i; ++k) x(i) -= L(i, k) * x(k);
  }
}

/// L^-T x in place of x.
template <int N, class Vector>
[[gnu::always_inline]] inline void substitute_backward(const Mat6& L, Vector& x) {
  for (int i = N - 2; i >= 0; --i) {
    for (int k = i + 1; k < N; ++k) x(i) -= L(k, i) * x(k);
  }
}

/// U L^-T in place of the first N columns of U.
template <int N>
[[gnu::always_inline]] inline void divide_by_transpose(const Mat6& L, Mat6& U) {
  for (int i = 1; i < N; ++i) {
    for (int k = 0; k < i; ++k) U.col(i) -= L(i, k) * U.col(k);
  }
}

/// The first N columns times as many factors, summed up.
template <int N, class Factors>
[[gnu::always_inline]] inline Vec6 combination(const Mat6& columns, const Factors& factors) {
  Vec6 sum = columns.col(0) * factors(0);
  for (int k = 1; k < N; ++k) sum += columns.col(k) * factors(k);
  return sum;
}

/// I - V W^T, of the first N columns of V and W, into another matrix.
template <int N>
[[gnu::always_inline]] inline void take_off_products(const Mat6& I, const Mat6& V, const Mat6& W, Mat6& rest) {
  const auto two_rows = [&](int row, int column) {
    Pair sum = load_pair(V.data() + row) * W(column, 0);
    for (int k = 1; k < N; ++k) sum += load_pair(V.data() + 6 * k + row) * W(column, k);
    store_pair(load_pair(I.data() + 6 * column + row) - sum, rest.data() + 6 * column + row);
  };
  const auto column = [&](int c) {
    two_rows(0, c);
    two_rows(2, c);
    two_rows(4, c);
  };
  column(0);
  column(1);
  column(2);
  column(3);
  column(4);
  column(5);
}

/// Adds Sh(rho)^T I Sh(rho) to a sum. With I = [A, B; B^T, C] it is [A, B'; B'^T, C'], where B' = B - A rho~ and
/// C' = C - B^T rho~ - (B'^T rho~)^T; a row x^T times rho~ is (x cross rho)^T. By pairs of rows, and the third.
[[gnu::always_inline]] inline void add_shifted(const Mat6& I, const Vec3& rho, Mat6& sum) {
  const double x = rho.x();
  const double y = rho.y();
  const double z = rho.z();
  const double* a = I.data();
  double* s = sum.data();
  const auto add_pair = [](const Pair& pair, double* to) { store_pair(load_pair(to) + pair, to); };
  const auto add_three = [&](const Pair& pair, double third, double* to) {
    add_pair(pair, to);
    to[2] += third;
  };
  const Pair A0 = load_pair(a);
  const Pair A1 = load_pair(a + 6);
  const Pair A2 = load_pair(a + 12);
  const Pair B0 = load_pair(a + 18) - (A1 * z - A2 * y);
  const Pair B1 = load_pair(a + 24) - (A2 * x - A0 * z);
  const Pair B2 = load_pair(a + 30) - (A0 * y - A1 * x);
  const double b0 = a[20] - (a[8] * z - a[14] * y);
  const double b1 = a[26] - (a[14] * x - a[2] * z);
  const double b2 = a[32] - (a[2] * y - a[8] * x);
  add_three(A0, a[2], s);
  add_three(A1, a[8], s + 6);
  add_three(A2, a[14], s + 12);
  add_three(B0, b0, s + 18);
  add_three(B1, b1, s + 24);
  add_three(B2, b2, s + 30);
  add_three(Pair{B0[0], B1[0]}, B2[0], s + 3);
  add_three(Pair{B0[1], B1[1]}, B2[1], s + 9);
  add_three(Pair{b0, b1}, b2, s + 15);
  // Rows of B, as B^T has them.
  const Pair r0 = load_pair(a + 3);
  const Pair r1 = load_pair(a + 9);
  const Pair r2 = load_pair(a + 15);
  const Pair zx{z, x};
  const Pair yz{y, z};
  const Pair C0 = load_pair(a + 21) - (r1 * z - r2 * y) - (Pair{B0[1], b0} * zx - Pair{b0, B0[0]} * yz);
  const Pair C1 = load_pair(a + 27) - (r2 * x - r0 * z) - (Pair{B1[1], b1} * zx - Pair{b1, B1[0]} * yz);
  const double c0 = a[23] - (a[11] * z - a[17] * y) - (B0[0] * y - B0[1] * x);
  const double c1 = a[29] - (a[17] * x - a[5] * z) - (B1[0] * y - B1[1] * x);
  const double c2 = a[35] - (a[5] * y - a[11] * x) - (B2[0] * y - B2[1] * x);
  add_three(C0, c0, s + 21);
  add_three(C1, c1, s + 27);
  add_three(Pair{c0, c1}, c2, s + 33);
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
