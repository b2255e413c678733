#pragma once

#include "cartesian/layout.h"
#include "common/types.h"

namespace concord::cartesian {

/// How far one step of Newton's method on positions may go: half a radian, so that no turn is lost and no other branch
/// is met, and half the machine's length. Where a step leaves of every residual what its first order says, as along a
/// slide that a rope hauls, the way is straight, and the next step may displace bodies twice as far.
class ClosingReach {
 public:
  /// The part of a step [dr; dpi; da], in the machine's units, that may be made; at most one.
  [[nodiscard]] double part_of(const Layout& layout, const VecX& step) const;
  /// Residuals before and after that `part` of a step was made.
  void learn(const VecX& before, const VecX& after, double part);

 private:
  static constexpr double kLargestTurn = 0.5;  // rad
  double farthest_ = kLargestTurn;             // of all else, in the machine's units
};

}  // namespace concord::cartesian
