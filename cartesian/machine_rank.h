#pragma once

#include "cartesian/closing.h"
#include "cartesian/dynamics.h"
#include "cartesian/equations.h"
#include "common/results.h"

namespace concord::cartesian {

/// What holds for a machine as a whole, whatever its pose: the rank of its constraints where it is not singular, and
/// whether closing has to move modes.
struct MachineRank {
  int generic = 0;
  Modes closing_modes = Modes::kept;
};

/// The start alone may be a singular pose; so poses round about are looked at too, closed without drivers: those to
/// which no body turns far, and that are not nearly singular themselves where there are others.
MachineRank decide_for_the_machine(Equations& equations, const State& start);

/// Takes rows that are independent at the last update, whatever was in use before, and solves with them. Throws
/// SingularPose where the rank is below the machine's, or where rows that depend on others contradict them.
const Solution& solve_with_independent_rows(Dynamics& dynamics, const MachineRank& machine);

}  // namespace concord::cartesian
