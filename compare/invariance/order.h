#pragma once

#include <vector>

#include "compare/invariance/change.h"

namespace concord::compare::invariance {

/// Orders of the parts of a machine: part k of the new description is part order[k] of the old one.
struct PartOrder {
  std::vector<int> bodies;  // ground stays first
  std::vector<int> joints;
  std::vector<int> couplings;
  std::vector<int> elements;
};

/// Describes the parts of a machine in another order.
Change in_order(const PartOrder& order);

}  // namespace concord::compare::invariance
