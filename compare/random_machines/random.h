#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "common/types.h"

namespace concord::compare::fuzz {

/// A generator of its own (xoshiro256**, seeded by splitmix64), written out: the distributions of the standard library
/// differ from one to another, and a seed must give the same machines everywhere.
class Random {
 public:
  /// The same two numbers give the same sequence; neighbouring streams of a seed have nothing in common.
  Random(std::uint64_t seed, std::uint64_t stream);

  std::uint64_t bits();
  /// In [0, 1).
  double uniform();
  double between(double least, double greatest);
  /// Uniform in the logarithm; both positive.
  double log_between(double least, double greatest);
  /// 0 to count - 1; `count` is positive.
  int below(int count);
  bool chance(double probability);
  /// Components in [-size, size).
  Vec3 vector(double size);
  VecX vector(Eigen::Index n, double size);
  /// Uniform over all rotations: Euler parameters, scalar first, not negative.
  Vec4 rotation();

 private:
  std::array<std::uint64_t, 4> state_{};
};

}  // namespace concord::compare::fuzz
