#pragma once

#include "common/joints/joint_type.h"

namespace concord::joints {

/// A ball in a socket: the points coincide. q = Euler parameters of the child's frame in the parent's, scalar first; u
/// = relative angular velocity, components in the parent's joint frame [rad/s]. Never singular.
inline const JointType spherical{
    .name = "spherical",
    .forbids = {Coincide{}},
    .permits = {Ball{}},
    .reads = {OrientationOf{}},
};

}  // namespace concord::joints
