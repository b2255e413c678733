#pragma once

#include "cartesian/dynamics/equations.h"
#include "common/solver.h"

namespace concord::cartesian {

/// Rank at the last update of `equations`, and which reaction components, coordinate forces and coupling forces stay
/// the same for all multipliers in the null space of Phi_Y^T; which of these answers another threshold would change.
RankReport report_rank(const Equations& equations);

}  // namespace concord::cartesian
