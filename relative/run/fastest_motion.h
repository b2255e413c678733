#pragma once

#include <string>

#include "relative/bodies/motion.h"
#include "relative/dynamics/equations.h"

namespace concord::relative {

/// The joint whose own speed changes its own acceleration, or whose own place does, at the largest rate
/// [1/s] at these coordinates; empty if all are zero. For messages.
struct FastestMotion {
  std::string of;
  double rate = 0.0;
};
FastestMotion fastest_motion(Equations& equations, const Coordinates& coordinates);

/// What makes a run costly at these coordinates, for the end of a message: the loop with the largest multiplier, and
/// the joint whose motion is the fastest.
std::string place_of_cost(Equations& equations, const Coordinates& coordinates);

}  // namespace concord::relative
