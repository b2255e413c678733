#pragma once

#include <string>
#include <vector>

#include "common/error.h"

namespace concord {

/// One joint coordinate (a turn, turns counted, or a slide) in a relation.
struct CouplingTerm {
  int joint = 0;
  int word = 0;
  int component = 0;  // of the word's coordinates, as in Driver
  double factor = 0.0;
};

/// An ideal relation between joint coordinates: sum of factor_k q_k = offset. Gears and belts (two turns), a rack on
/// its pinion (a slide and a turn), a differential (three turns). Its force f pushes the sum to grow if positive: the
/// coordinate force on q_k is tau_k = factor_k f, and what it exerts on the joint's two bodies is the coordinate wrench
/// of tau_k there, as of a driver. So its power is f times the rate of the sum, which is zero (S26).
struct Coupling {
  std::string name;
  std::vector<CouplingTerm> terms;  // at least two, each coordinate once
  double offset = 0.0;
  SourceLocation where;
};

}  // namespace concord
