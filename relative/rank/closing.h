#pragma once

#include <optional>
#include <vector>

#include "relative/rank/scaled_closure.h"

/// Closing a machine from afar by Newton's method, with any of its coordinates prescribed.
namespace concord::relative {

/// Moves the machine and measures its cut joints with a closure of its own; returns the largest position residual in
/// machine units.
double measure(const ScaledClosure& scaled, Coordinates& coordinates, Closure& closure);
/// The same; infinite where the machine has no such pose.
double try_to_measure(const ScaledClosure& scaled, Coordinates& coordinates, Closure& closure);

/// The smallest step (n_tree_u numbers, in machine units) of the given columns that takes the misfit, of as many rows
/// as it has, away to first order (R65). Rows that are far from dependent are left without their singular values, which
/// would take most of a closing's time.
[[nodiscard]] VecX smallest_step(const ScaledClosure& scaled, const Closure& closure, const std::vector<int>& columns,
                                 const VecX& misfit, double damping, std::optional<int> rank = {});

/// Newton's method with damping and halved steps, until round-off stops it. Prescribed coordinates stay. False if the
/// loops do not close. `rank`: of the rows in closed poses; beside these an overconstrained mechanism that moves has
/// more, which come from the misfit and ask for steps along its motion: as many singular values are used.
[[nodiscard]] bool close_positions(const ScaledClosure& scaled, Coordinates& coordinates,
                                   const PrescribedMask& prescribed, Modes modes, std::optional<int> rank = {});
/// The smallest change of the speeds that are not prescribed with which the closed machine keeps its constraints. False
/// if there is none.
[[nodiscard]] bool close_velocities(const ScaledClosure& scaled, Coordinates& coordinates,
                                    const PrescribedMask& prescribed, Modes modes);

}  // namespace concord::relative
