#pragma once

#include "common/types.h"

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

/// I - V W^T for the first N columns of V and W.
template <int N>
[[gnu::always_inline]] inline Mat6 without_products(const Mat6& I, const Mat6& V, const Mat6& W) {
  if constexpr (N == 1) return I - V.col(0).lazyProduct(W.col(0).transpose());
  Mat6 rest = I;
  for (int j = 0; j < 6; ++j) rest.col(j) -= combination<N>(V, W.row(j));
  return rest;
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
