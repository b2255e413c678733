#pragma once

#include "common/pair.h"
#include "common/types.h"

/// Products of three and six rows, inlined by force, whose numbers are stored in pairs, as they are read again; Eigen
/// stores them one by one.
namespace concord::cartesian {

[[gnu::always_inline]] inline Vec3 vector_of(const Pair& xy, double z) {
  Vec3 result;
  store_pair(xy, result.data());
  result.z() = z;
  return result;
}

/// a x b.
template <class A, class B>
[[gnu::always_inline]] inline Vec3 cross(const A& a, const B& b) {
  return vector_of(Pair{a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z()}, a.x() * b.y() - a.y() * b.x());
}

/// A x.
template <class X>
[[gnu::always_inline]] inline Vec3 times(const Mat3& A, const X& x) {
  const double* a = A.data();
  return vector_of(load_pair(a) * x.x() + load_pair(a + 3) * x.y() + load_pair(a + 6) * x.z(),
                   a[2] * x.x() + a[5] * x.y() + a[8] * x.z());
}

/// A^T x.
template <class X>
[[gnu::always_inline]] inline Vec3 transpose_times(const Mat3& A, const X& x) {
  const double* a = A.data();
  return vector_of(Pair{a[0], a[3]} * x.x() + Pair{a[1], a[4]} * x.y() + Pair{a[2], a[5]} * x.z(),
                   a[6] * x.x() + a[7] * x.y() + a[8] * x.z());
}

/// A B and A^T B, into another matrix than either.
[[gnu::always_inline]] inline void multiply(const Mat3& A, const Mat3& B, Mat3& AB) {
  for (int c = 0; c < 3; ++c) AB.col(c) = times(A, B.col(c));
}
[[gnu::always_inline]] inline void transpose_times(const Mat3& A, const Mat3& B, Mat3& AtB) {
  for (int c = 0; c < 3; ++c) AtB.col(c) = transpose_times(A, B.col(c));
}

/// A^T x of a matrix of six rows and columns.
template <class A>
[[gnu::always_inline]] inline Vec6 transpose_times(const A& columns, const Vec6& x) {
  const Pair x0 = load_pair(x.data());
  const Pair x1 = load_pair(x.data() + 2);
  const Pair x2 = load_pair(x.data() + 4);
  Vec6 result;
#pragma GCC unroll 3
  for (int c = 0; c < 6; c += 2) {
    const double* a = columns.data() + 6 * c;
    const Pair first = load_pair(a) * x0 + load_pair(a + 2) * x1 + load_pair(a + 4) * x2;
    const Pair second = load_pair(a + 6) * x0 + load_pair(a + 8) * x1 + load_pair(a + 10) * x2;
    store_pair(Pair{first[0], second[0]} + Pair{first[1], second[1]}, result.data() + c);
  }
  return result;
}

}  // namespace concord::cartesian
