#pragma once

#include "common/types.h"

namespace concord::relative {

/// Internal coordinates and speeds, in the order of Topology.
struct Coordinates {
  double t = 0.0;
  VecX q;
  VecX u;
};

}  // namespace concord::relative
