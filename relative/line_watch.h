#pragma once

#include <vector>

#include "relative/applied_forces.h"

namespace concord::relative {

/// Sees where the ends of a line spring meet between two steps of a run, its force being without direction there.
///
/// Where the ends pass each other, the line from one to the other turns over within the step, however short that is,
/// and they move along it; where they turn round just there, they touch. A spring whose force vanishes there is smooth,
/// and the run goes on.
class LineWatch {
 public:
  /// `length`: the machine's.
  explicit LineWatch(double length = 1.0) : length_(length) {}

  /// A step has come to t, where the forces have been updated. Steps may be made anew from an earlier time: those that
  /// ended at t or later are forgotten, and a step is looked at when the next one is known to follow it. Throws
  /// SolverError, naming the element.
  void pass(double t, const AppliedForces& forces);
  /// Looks at the last step too: it is final.
  void settle();

 private:
  struct Record {
    double t;
    std::vector<LineState> lines;
  };

  double length_;
  std::vector<Record> last_;  // the begin of a step that has not been looked at, and its end
};

}  // namespace concord::relative
