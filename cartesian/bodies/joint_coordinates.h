#pragma once

#include <vector>

#include "cartesian/bodies/constraints.h"
#include "common/results.h"

namespace concord::cartesian {

/// Coordinates and speeds of every joint, as the types' reads say: turn angles within half a turn of those in `q`,
/// Euler parameters of the sign nearest to them. `q` and `u` hold one vector for each joint, sized for its type.
void read_joint_coordinates(const Model& model, const MovingConstraints& constraints, std::vector<VecX>& q,
                            std::vector<VecX>& u);

/// The coordinates that the model names for the start (driven ones: their law at t = 0; a turn that only a coupling
/// says: as many times round as that asks for), zero speeds.
std::vector<VecX> start_coordinates(const Model& model);
std::vector<VecX> zero_speeds(const Model& model);

}  // namespace concord::cartesian
