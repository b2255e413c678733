#pragma once

#include "common/joints/joint_type.h"

namespace concord::joints {

/// A slide in a keyed guide: the child moves along the parent's z without turning. q = displacement along z [m]. Never
/// singular. The guide is the parent: the joint acts on it at P_j, wherever the child has slid to.
inline const JointType translational{
    .name = "translational",
    .forbids = {NoGapAlong{Axis::x}, NoGapAlong{Axis::y}, SameOrientation{}},
    .permits = {Slide{Axis::z}},
    .reads = {SlideAlong{Axis::z}},
};

}  // namespace concord::joints
