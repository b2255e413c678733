#pragma once

#include <vector>

#include "cartesian/applied_forces.h"

namespace concord::cartesian {

/// Follows the directions of line springs from step to step, and sees where a spring's ends have met in between.
///
/// A point that passes through the other end leaves on the far side: the unit vector along the line is reversed, and
/// the point headed against it before as it heads along it behind. A line that only turns, be it fast, is crossed by
/// the heading instead. A spring that pulls with nothing where its ends meet, as one of free length 0 does, has a force
/// without a jump and may pass.
class LineWatch {
 public:
  /// At time t, where the forces were updated last; `length`: the machine's.
  LineWatch(double t, const AppliedForces& applied, double length);

  /// The motion has come to t by one step, and the forces are updated there. Throws SolverError, naming the spring.
  void follow(double t, const AppliedForces& applied);

 private:
  double t_;
  double length_;
  std::vector<SpringLine> lines_;
};

}  // namespace concord::cartesian
