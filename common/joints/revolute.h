#pragma once

#include "common/joints/joint_type.h"

namespace concord::joints {

/// A hinge: the points coincide and the z axes are one. q = angle about z from parent's x to child's x [rad]; q = 0:
/// the frames coincide. Never singular.
inline const JointType revolute{
    .name = "revolute",
    .forbids = {Coincide{}, SameDirection{Axis::z}},
    .permits = {Turn{Axis::z}},
    .reads = {TurnOfChildAxis{.about = Axis::z, .of_child_axis = Axis::x}},
};

}  // namespace concord::joints
