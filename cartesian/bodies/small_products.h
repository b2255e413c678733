#pragma once

#include "common/types.h"

/// Products of three and six rows, inlined by force, whose numbers are stored two at once, as they are read again: a
/// processor that reads two numbers at once waits long if they were stored one by one, as Eigen's are.
namespace concord::cartesian {

/// Two numbers that one instruction handles.
using Two [[gnu::vector_size(16)]] = double;

/// From and to any address.
[[gnu::always_inline]] inline Two load_two(const double* numbers) {
  Two two;
  __builtin_memcpy(&two, numbers, sizeof(two));
  return two;
}
[[gnu::always_inline]] inline void store_two(const Two& two, double* numbers) {
  __builtin_memcpy(numbers, &two, sizeof(two));
}

[[gnu::always_inline]] inline Vec3 vector(const Two& xy, double z) {
  Vec3 result;
  store_two(xy, result.data());
  result.z() = z;
  return result;
}

/// a x b.
template <class A, class B>
[[gnu::always_inline]] inline Vec3 cross(const A& a, const B& b) {
  return vector(Two{a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z()}, a.x() * b.y() - a.y() * b.x());
}

/// A x.
template <class X>
[[gnu::always_inline]] inline Vec3 times(const Mat3& A, const X& x) {
  const double* a = A.data();
  return vector(load_two(a) * x.x() + load_two(a + 3) * x.y() + load_two(a + 6) * x.z(),
                a[2] * x.x() + a[5] * x.y() + a[8] * x.z());
}

/// A^T x.
template <class X>
[[gnu::always_inline]] inline Vec3 transpose_times(const Mat3& A, const X& x) {
  const double* a = A.data();
  return vector(Two{a[0], a[3]} * x.x() + Two{a[1], a[4]} * x.y() + Two{a[2], a[5]} * x.z(),
                a[6] * x.x() + a[7] * x.y() + a[8] * x.z());
}

/// A B and A^T B, into another matrix than either.
[[gnu::always_inline]] inline void multiply(const Mat3& A, const Mat3& B, Mat3& AB) {
  for (int c = 0; c < 3; ++c) AB.col(c) = times(A, B.col(c));
}
[[gnu::always_inline]] inline void multiply_transpose(const Mat3& A, const Mat3& B, Mat3& AtB) {
  for (int c = 0; c < 3; ++c) AtB.col(c) = transpose_times(A, B.col(c));
}

/// A^T x of a matrix of six rows and columns.
template <class A>
[[gnu::always_inline]] inline Vec6 transpose_times(const A& columns, const Vec6& x) {
  const Two x0 = load_two(x.data());
  const Two x1 = load_two(x.data() + 2);
  const Two x2 = load_two(x.data() + 4);
  Vec6 result;
#pragma GCC unroll 3
  for (int c = 0; c < 6; c += 2) {
    const double* a = columns.data() + 6 * c;
    const Two first = load_two(a) * x0 + load_two(a + 2) * x1 + load_two(a + 4) * x2;
    const Two second = load_two(a + 6) * x0 + load_two(a + 8) * x1 + load_two(a + 10) * x2;
    store_two(Two{first[0], second[0]} + Two{first[1], second[1]}, result.data() + c);
  }
  return result;
}

}  // namespace concord::cartesian
