#pragma once

#include <vector>

#include "cartesian/dynamics/equations.h"
#include "common/results.h"

/// Whether a state that somebody hands over is one of the machine: of its shape, closed, and on the branches and
/// turns that it names.
namespace concord::cartesian {

/// Refuses a state that has not as many bodies, joints, modal and joint coordinates as the machine. Throws SolverError.
void require_shape(const Model& model, const State& state);

/// Refuses a state, to which the equations are updated, that its own constraints do not call closed: rows in the
/// machine's units, far from the origin relative to the distance, whose round-off they carry; velocities relative to
/// the largest. `q`, `Y`: its numbers. Throws SolverError, OpenState if it is open.
void refuse_open(const Equations& equations, const State& state, const VecX& q, const VecX& Y);

inline constexpr double kHalfTurn = EIGEN_PI;
inline constexpr double kQuarterTurn = 0.5 * EIGEN_PI;

/// Whether at the last update a joint's reading that counts turns is further from its coordinate in q [rad] than
/// `allowed`.
bool is_turned_beyond(const Equations& equations, double allowed, const std::vector<VecX>& q);

/// Refuses a state in which a joint stands on another branch than its type means, where its rows vanish too (a hinge
/// with its axes opposed), or on another turn of a thread than its coordinates say. Throws SolverError.
void refuse_other_branch(const Equations& equations, const State& state);

}  // namespace concord::cartesian
