#pragma once

#include "common/joints/joint_type.h"

namespace concord::joints {

/// The two joint frames are one. No coordinate.
inline const JointType weld{
    .name = "weld",
    .forbids = {Coincide{}, SameOrientation{}},
    .permits = {},
    .reads = {},
};

}  // namespace concord::joints
