#pragma once

#include "common/joints/joint_type.h"

namespace concord::joints {

/// Two yokes on a cross. x of the parent's joint frame is the yoke axis on the parent, y of the child's the one on the
/// child; they stay perpendicular. q = (angle about the parent's x, then angle about the child's y) [rad]; q = 0: the
/// frames coincide. Never singular itself; with shafts along z no torque passes about the parent's z at |q1| = 90 deg,
/// about the child's z at |q2| = 90 deg, and a loop that relies on it may lock there.
inline const JointType universal{
    .name = "universal",
    .forbids = {Coincide{}, Perpendicular{.on_parent = Axis::x, .on_child = Axis::y}},
    .permits = {Turn{Axis::x}, Turn{Axis::y}},
    .reads = {TurnOfChildAxis{.about = Axis::x, .of_child_axis = Axis::y},
              TurnOfParentAxis{.about = Axis::y, .of_parent_axis = Axis::x}},
};

}  // namespace concord::joints
