#pragma once

#include "common/solver.h"
#include "relative/rank/scaled_closure.h"

/// Rank of the constraints, uniqueness of the reactions and permitted velocities, (R67) to (R69), from
/// Phi_u alone.
namespace concord::relative {

/// The report for a closed state. The joints of the tree are independent by construction: they and their drivers add
/// their rows to both counts; the closure rows decide the rest. Self-stresses Z, Phi_u^T Z = 0 over the free columns,
/// are carried through the backward pass without inertia and load; a component that any of them moves is not unique.
RankReport analyze_rank(const ScaledClosure& scaled, const Coordinates& coordinates);

/// Columns that span the velocities Y of all bodies which the constraints permit in a closed state with drivers at
/// rest, Solver::tangent: B N with Phi_u N = 0 over the free columns, v in units of the machine's length; orthonormal
/// in the units of the machine.
MatX permitted_velocities(const ScaledClosure& scaled, const Coordinates& coordinates);  // (R69)

}  // namespace concord::relative
