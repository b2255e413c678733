#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compare/joint_check/property.h"
#include "compare/joint_check/rig.h"

/// States, turns and ranks of the joint in its rigs, by both solvers.
namespace concord::compare::joint_check {

/// Whether each solver accepts the other's states at the poses.
void exchange_states(Rig& rig, std::uint32_t seed, const std::vector<int>& poses, const std::string& context,
                     Property& property);

/// Whether each opinion counts turns along a way of several turns to both sides.
void follow_turns(Rig& rig, Property& property);

/// Whether the constraints have full rank and every reaction is unique, by every opinion.
void require_rank(Rig& rig, const Arrangement& arrangement, int pose, Property& property);

}  // namespace concord::compare::joint_check
