#pragma once

#include "common/solver.h"
#include "compare/audit/joint_motion.h"

/// What joints do between two states, and along a direction of motion.
namespace concord::compare {

/// The motion of joint k in a state.
JointMotion motion_of(const Model& model, std::size_t k, const State& state);

/// Speeds of all joints; slides by the machine's length.
VecX joint_speeds(const Model& model, const State& state);

/// By how much the coordinates of all joints differ in `state` from those in `start`, in the rows of joint_speeds(); of
/// a ball by the rotation vector of its turn.
VecX joint_displacements(const Model& model, const State& start, const State& state);

/// Rates W of joint speeds, weighed so that (W^T W)^-1 W^T moved is Newton's step of |moved|^2 / 2 for
/// joint_displacements() `moved`, but for how the motions themselves bend: across the turn theta of a ball its
/// curvature is (theta / 2) cot(theta / 2), not 1.
MatX weighed_by_nearness(const Model& model, const VecX& moved, MatX rates);

}  // namespace concord::compare
