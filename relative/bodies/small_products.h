#pragma once

#include "common/pair.h"
#include "common/types.h"

/// Products of three and six rows, written out over pairs of numbers and inlined by force: compilers leave Eigen's as
/// calls, or spend more on them than on the sums themselves. Each sum keeps Eigen's order, column after column.
namespace concord::relative {

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

/// The columns of a matrix of three rows, held where several products need them.
struct ThreeColumns {
  Pair upper[3];
  double last[3];

  [[gnu::always_inline]] explicit ThreeColumns(const Mat3& A)
      : upper{load_pair(A.data()), load_pair(A.data() + 3), load_pair(A.data() + 6)}, last{A(2, 0), A(2, 1), A(2, 2)} {}

  /// The columns times x, y, z: the first two rows, and the third.
  [[gnu::always_inline]] [[nodiscard]] Pair upper_times(double x, double y, double z) const {
    return upper[0] * x + upper[1] * y + upper[2] * z;
  }
  [[gnu::always_inline]] [[nodiscard]] double last_times(double x, double y, double z) const {
    return last[0] * x + last[1] * y + last[2] * z;
  }
  /// The same, written to three numbers.
  [[gnu::always_inline]] void multiply(double x, double y, double z, double* result) const {
    store_pair(upper_times(x, y, z), result);
    result[2] = last_times(x, y, z);
  }
};

/// A B, which is another matrix than either.
[[gnu::always_inline]] inline void multiply(const Mat3& A, const Mat3& B, Mat3& AB) {
  const ThreeColumns a(A);
  const double* b = B.data();
  a.multiply(b[0], b[1], b[2], AB.data());
  a.multiply(b[3], b[4], b[5], AB.data() + 3);
  a.multiply(b[6], b[7], b[8], AB.data() + 6);
}

/// A B^T, which is another matrix than either.
[[gnu::always_inline]] inline void multiply_transpose(const Mat3& A, const Mat3& B, Mat3& ABt) {
  const ThreeColumns a(A);
  const double* b = B.data();
  a.multiply(b[0], b[3], b[6], ABt.data());
  a.multiply(b[1], b[4], b[7], ABt.data() + 3);
  a.multiply(b[2], b[5], b[8], ABt.data() + 6);
}

/// x and six numbers more, two at once.
[[gnu::always_inline]] inline Vec6 sum_of_pairs(const Vec6& x, const Pair& first, const Pair& second,
                                                const Pair& third) {
  Vec6 sum;
  store_pair(load_pair(x.data()) + first, sum.data());
  store_pair(load_pair(x.data() + 2) + second, sum.data() + 2);
  store_pair(load_pair(x.data() + 4) + third, sum.data() + 4);
  return sum;
}

/// [upper; lower], stored two numbers at once as they are read again: a processor waits long for a pair whose halves
/// were stored apart.
[[gnu::always_inline]] inline Vec6 stack(const Vec3& upper, const Vec3& lower) {
  Vec6 result;
  store_pair(load_pair(upper.data()), result.data());
  store_pair(Pair{upper.z(), lower.x()}, result.data() + 2);
  store_pair(load_pair(lower.data() + 1), result.data() + 4);
  return result;
}

/// a x b.
[[gnu::always_inline]] inline Vec3 cross(const Vec3& a, const Vec3& b) {
  Vec3 result;
  store_pair(Pair{a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z()}, result.data());
  result.z() = a.x() * b.y() - a.y() * b.x();
  return result;
}

/// A^T F and A^T T of a wrench w = [F; T], both at once.
[[gnu::always_inline]] inline Vec6 transpose_times_both(const Mat3& A, const Vec6& w) {
  const double* a = A.data();
  const Pair x{w(0), w(3)};
  const Pair y{w(1), w(4)};
  const Pair z{w(2), w(5)};
  const Pair first = x * a[0] + y * a[1] + z * a[2];
  const Pair second = x * a[3] + y * a[4] + z * a[5];
  const Pair third = x * a[6] + y * a[7] + z * a[8];
  Vec6 result;
  store_pair(Pair{first[0], second[0]}, result.data());
  store_pair(Pair{third[0], first[1]}, result.data() + 2);
  store_pair(Pair{second[1], third[1]}, result.data() + 4);
  return result;
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
