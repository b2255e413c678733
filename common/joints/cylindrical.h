#pragma once

#include "common/joints/joint_type.h"

namespace concord::joints {

/// A round bar in a sleeve: the child moves along the parent's z and turns about it. q = (displacement along z [m],
/// angle about z from parent's x to child's x [rad]). Never singular.
inline const JointType cylindrical{
    .name = "cylindrical",
    .forbids = {NoGapAlong{Axis::x}, NoGapAlong{Axis::y}, SameDirection{Axis::z}},
    .permits = {Slide{Axis::z}, Turn{Axis::z}},
    .reads = {SlideAlong{Axis::z}, TurnOfChildAxis{.about = Axis::z, .of_child_axis = Axis::x}},
};

}  // namespace concord::joints
