#pragma once

#include <string>
#include <vector>

#include "common/types.h"

namespace concord {

/// The line of a line spring at some time, as a solver finds it.
struct SpringLine {
  const std::string* name;
  Vec3 span;                     // from the parent's end to the child's, global axes [m]
  Vec3 rate;                     // its rate of change [m/s]
  bool is_reversed_with_a_jump;  // the force jumps where the ends pass each other at the present speed
};

/// Sees where the ends of a line spring meet between two steps of a run, its force being without direction there.
///
/// Where the ends pass each other, the line from one to the other turns over within the step, however short that is,
/// and they move along it; where they turn round just there, they touch. A line that only turns, be it fast, is crossed
/// by the motion instead. A spring that pulls with nothing where its ends meet, as one of free length 0 does, has a
/// force without a jump, and the run goes on.
class LineWatch {
 public:
  /// `solver`: in whose name a message speaks; `length`: the machine's [m].
  LineWatch(std::string solver, double length) : solver_(std::move(solver)), length_(length) {}

  /// A step has come to t, with these lines there, the same springs each time. Steps may be made anew from an earlier
  /// time: those that ended at t or later are forgotten, and a step is looked at when the next one is known to follow
  /// it. Throws SolverError, naming the spring.
  void pass(double t, std::vector<SpringLine> lines);
  /// Looks at the last step too: it is final.
  void settle();

 private:
  struct Record {
    double t;
    std::vector<SpringLine> lines;
  };

  std::string solver_;
  double length_;
  std::vector<Record> last_;  // the begin of a step that has not been looked at, and its end
};

}  // namespace concord
