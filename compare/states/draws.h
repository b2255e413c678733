#pragma once

#include <cmath>
#include <cstdint>

namespace concord::compare {

/// Of the random states, and of the draws within round-off, where none is asked for.
inline constexpr std::uint64_t kSeed = 19971025;

/// Uniform numbers by splitmix64: the same ones for the same seed on every machine and by every compiler.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : state_(seed) {}

  /// The next number in [-1, 1).
  double next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    z ^= z >> 31U;
    return std::ldexp(static_cast<double>(z >> 11U), -52) - 1.0;
  }

 private:
  std::uint64_t state_;
};

}  // namespace concord::compare
