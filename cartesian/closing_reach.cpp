#include "cartesian/closing_reach.h"

#include <algorithm>
#include <cmath>

namespace concord::cartesian {

double ClosingReach::part_of(const Layout& layout, const VecX& step) const {
  double turn = 0.0;
  double other = 0.0;
  for (const BodyIndex i : layout.moving_bodies()) {
    const Eigen::Index first = layout.first_Y(i);
    for (int c = 0; c < layout.size_Y(i); ++c) {
      double& largest = c >= 3 && c < 6 ? turn : other;
      largest = std::max(largest, std::abs(step(first + c)));
    }
  }
  return std::min({1.0, kLargestTurn / std::max(turn, kLargestTurn), farthest_ / std::max(other, farthest_)});
}

void ClosingReach::learn(const VecX& before, const VecX& after, double part) {
  constexpr double kStraight = 0.01;  // of what the step takes away
  constexpr double kNothing = 1e-9;   // of the largest residual
  const VecX bent = (after - (1.0 - part) * before).cwiseAbs();
  const double floor = before.size() == 0 ? 0.0 : kNothing * before.lpNorm<Eigen::Infinity>();
  const bool is_straight = (bent.array() <= kStraight * part * before.array().abs() + floor).all();
  farthest_ = is_straight ? 2.0 * farthest_ : kLargestTurn;
}

}  // namespace concord::cartesian
