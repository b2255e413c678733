#pragma once

#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "common/model.h"
#include "common/rotation.h"
#include "compare/states/draws.h"

namespace concord::compare::invariance {

/// Poses, orders and numbers of a seed: the same ones on every machine.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : draws_(seed) {}

  /// A number in [-size, size).
  double one(double size = 1.0) { return size * draws_.next(); }
  /// An angle between 0.3 and 1.3 rad, of either sign: no quarter turn, and far from none.
  double angle() {
    const double drawn = draws_.next();
    return std::copysign(0.3 + std::abs(drawn), drawn);
  }
  Vec3 vector(double size) {
    const double x = one(size);
    const double y = one(size);
    return {x, y, one(size)};
  }
  Mat3 rotation() {
    Vec3 axis = vector(1.0);
    while (axis.norm() < 0.1) axis = vector(1.0);
    return rotation_about(Vec3(axis.normalized()), 2.0 * angle());
  }
  Pose pose(double size) {
    const Vec3 place = vector(size);
    return {place, rotation()};
  }
  /// A permutation that leaves 0 .. first - 1 in place, and none of `first` .. n - 1.
  std::vector<int> order(std::size_t n, std::size_t first) {
    std::vector<int> order(n);
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t last = n; last > first + 1; --last) {
      const auto choices = static_cast<double>(last - first - 1);
      const auto chosen = static_cast<std::size_t>(0.5 * (draws_.next() + 1.0) * choices);
      std::swap(order[last - 1], order[first + chosen]);
    }
    return order;
  }

 private:
  Draws draws_;
};

}  // namespace concord::compare::invariance
