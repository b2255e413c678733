#pragma once

#include <vector>

#include "compare/invariance/change.h"

namespace concord::compare::invariance {

/// Combines the modes of every flexible body anew, a = T b with a regular T for each body (0 x 0 for rigid ones).
Change with_modes(const std::vector<MatX>& T);

}  // namespace concord::compare::invariance
