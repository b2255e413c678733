#pragma once

#include <vector>

#include "cartesian/dynamics/dynamics.h"
#include "cartesian/dynamics/equations.h"
#include "common/results.h"

/// What is reported of a machine: the last phase.
namespace concord::cartesian {

/// The state of the last update, which was at these q and Y, with joint coordinates near `known` (by joint).
State reported_state(const Equations& equations, const VecX& q, const VecX& Y, const std::vector<VecX>& known);

/// Accelerations alone in the state that was solved for.
Evaluation reported_accelerations(const Equations& equations, const Solution& solution);

/// Accelerations, wrenches of joints and elements, and forces of couplings in the state that was solved for.
Evaluation reported_evaluation(const Equations& equations, const Solution& solution);

}  // namespace concord::cartesian
