#pragma once

#include "common/types.h"

namespace concord {

/// Where a joint or a force element sits on a body: undeformed point s_P0 [m] and frame (C: joint frame to body axes),
/// and there the translation and rotation rows of the body's mode shapes (3 x m; no columns on a rigid body) (S1).
struct Attachment {
  int body = kGround;
  Vec3 point_L = Vec3::Zero();
  Mat3 C = Mat3::Identity();
  Mat3X Psi_t_L = Mat3X(3, 0);
  Mat3X Psi_r_L = Mat3X(3, 0);
};

}  // namespace concord
