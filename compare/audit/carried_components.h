#pragma once

#include <array>

#include "common/joints/joint_type.h"

/// Which components of a joint's reaction its statement leaves room for.
namespace concord::compare {

/// Whether the joint can carry a reaction in `component` (0..2 force x, y, z; 3..5 torque x, y, z) on `side`: on the
/// child at P_i in the child's joint frame, on the parent at P_j in the parent's. False where the direction is
/// permitted at every pose, so that the component vanishes always (S24): then it is no agreement that both solvers say
/// zero. Of a motion by functions that is asked at 64 poses, within the ranges that its page states; where a function
/// is not defined, everything is carried.
bool carries(const joints::JointType& type, Side side, int component);

/// carries() of all components, by side.
using CarriedComponents = std::array<std::array<bool, 6>, 2>;
CarriedComponents carried_components(const joints::JointType& type);

}  // namespace concord::compare
