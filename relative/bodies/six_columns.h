#pragma once

#include "common/types.h"

namespace concord::relative {

/// Of several motions, one that keeps less than this part beside the others is one of them: a joint is singular there.
inline constexpr double kLeastOwnPart = 1e-6;

/// Orthonormal directions in six dimensions, gathered one by one without heap memory.
class OrthonormalColumns {
 public:
  /// What is left of v when its parts along the directions so far are taken off.
  [[nodiscard]] Vec6 rest(Vec6 v) const {
    for (int round = 0; round < 2; ++round) {  // once more for round-off
      for (int c = 0; c < n_; ++c) v -= directions_.col(c).dot(v) * directions_.col(c);
    }
    return v;
  }

  /// Takes the direction of `rest`, which is not zero.
  void add(const Vec6& rest) { directions_.col(n_++) = rest.normalized(); }

  /// Adds unit vectors of the axes, the farthest from the directions so far first, until all six dimensions are filled.
  void complete() {
    while (n_ < 6) {
      Vec6 farthest = Vec6::Zero();
      for (int axis = 0; axis < 6; ++axis) {
        const Vec6 candidate = rest(Vec6::Unit(axis));
        if (candidate.squaredNorm() > farthest.squaredNorm()) farthest = candidate;
      }
      add(farthest);
    }
  }

  [[nodiscard]] int size() const { return n_; }
  [[nodiscard]] const Mat6& directions() const { return directions_; }

 private:
  Mat6 directions_ = Mat6::Zero();
  int n_ = 0;
};

}  // namespace concord::relative
