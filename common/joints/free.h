#pragma once

#include "common/joints/joint_type.h"

namespace concord::joints {

/// Six degrees of freedom: forbids nothing, carries nothing, and gives a body coordinates. q = (d [m], Euler parameters
/// of the child's frame in the parent's, scalar first); u = (ddot [m/s], relative angular velocity [rad/s]), all
/// components in the parent's joint frame. Never singular.
inline const JointType free{
    .name = "free",
    .forbids = {},
    .permits = {Slide{Axis::x}, Slide{Axis::y}, Slide{Axis::z}, Ball{}},
    .reads = {SlideAlong{Axis::x}, SlideAlong{Axis::y}, SlideAlong{Axis::z}, OrientationOf{}},
};

}  // namespace concord::joints
