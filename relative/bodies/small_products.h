#pragma once

#include "common/types.h"

/// Products of three and six rows, written out over pairs of numbers and inlined by force: compilers leave Eigen's as
/// calls, or spend more on them than on the sums themselves. Each sum keeps Eigen's order, column after column.
namespace concord::relative {

/// Two numbers that one instruction handles.
using Pair [[gnu::vector_size(16)]] = double;

/// From and to any address.
[[gnu::always_inline]] inline Pair load_pair(const double* numbers) {
  Pair pair;
  __builtin_memcpy(&pair, numbers, sizeof(pair));
  return pair;
}
[[gnu::always_inline]] inline void store_pair(const Pair& pair, double* numbers) {
  __builtin_memcpy(numbers, &pair, sizeof(pair));
}

/// A x of three rows; `x` and `result` point to three numbers each.
[[gnu::always_inline]] inline void multiply(const Mat3& A, const double* x, double* result) {
  const double* a = A.data();
  const Pair upper = load_pair(a) * x[0] + load_pair(a + 3) * x[1] + load_pair(a + 6) * x[2];
  const double last = a[2] * x[0] + a[5] * x[1] + a[8] * x[2];
  store_pair(upper, result);
  result[2] = last;
}

[[gnu::always_inline]] inline Vec3 times(const Mat3& A, const Vec3& x) {
  Vec3 result;
  multiply(A, x.data(), result.data());
  return result;
}

/// A^T x of three rows.
[[gnu::always_inline]] inline void multiply_transpose(const Mat3& A, const double* x, double* result) {
  const double* a = A.data();
  const double first = a[0] * x[0] + a[1] * x[1] + a[2] * x[2];
  const double second = a[3] * x[0] + a[4] * x[1] + a[5] * x[2];
  result[2] = a[6] * x[0] + a[7] * x[1] + a[8] * x[2];
  result[0] = first;
  result[1] = second;
}

/// A B, which is another matrix than either.
[[gnu::always_inline]] inline void multiply(const Mat3& A, const Mat3& B, Mat3& AB) {
  multiply(A, B.data(), AB.data());
  multiply(A, B.data() + 3, AB.data() + 3);
  multiply(A, B.data() + 6, AB.data() + 6);
}

/// A B^T, which is another matrix than either.
[[gnu::always_inline]] inline void multiply_transpose(const Mat3& A, const Mat3& B, Mat3& ABt) {
  const double* b = B.data();
  const double rows[9] = {b[0], b[3], b[6], b[1], b[4], b[7], b[2], b[5], b[8]};
  multiply(A, rows, ABt.data());
  multiply(A, rows + 3, ABt.data() + 3);
  multiply(A, rows + 6, ABt.data() + 6);
}

/// a x b.
[[gnu::always_inline]] inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}

/// Two rows of M x.
[[gnu::always_inline]] inline Pair two_rows(const double* M, const double* x) {
  return load_pair(M) * x[0] + load_pair(M + 6) * x[1] + load_pair(M + 12) * x[2] + load_pair(M + 18) * x[3] +
         load_pair(M + 24) * x[4] + load_pair(M + 30) * x[5];
}

/// M x of six rows.
[[gnu::always_inline]] inline Vec6 times(const Mat6& M, const Vec6& x) {
  Vec6 result;
  store_pair(two_rows(M.data(), x.data()), result.data());
  store_pair(two_rows(M.data() + 2, x.data()), result.data() + 2);
  store_pair(two_rows(M.data() + 4, x.data()), result.data() + 4);
  return result;
}

}  // namespace concord::relative
