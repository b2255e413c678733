#pragma once

#include "common/results.h"
#include "relative/velocity_transformation.h"

namespace concord::relative {

/// A wrench [F; T] about one point of a frame, global axes, in that frame's axes, paper (29), and in global ones. It
/// is what is reported on either side of a joint (R30).
inline SideWrench in_both_frames(const Mat3& A_joint, const Vec6& w) {
  return {{A_joint.transpose() * w.head<3>(), A_joint.transpose() * w.tail<3>()}, {w.head<3>(), w.tail<3>()}};
}

/// The opposite wrench, moved from the point `from` to the point `to`: the wrench on the other side (R30).
inline Vec6 opposite_wrench_at(const Vec6& wrench, const Vec3& from, const Vec3& to) {
  return -shift_wrench(wrench, from - to);
}

}  // namespace concord::relative
