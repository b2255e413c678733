#pragma once

#include "common/joints/joint_type.h"

namespace concord::joints {

/// A rod without mass between two balls; it pushes and pulls along itself and turns about itself as it likes (that turn
/// is no coordinate). q = (turn_x, turn_y, ball): the rod points along the parent's z, turned about the parent's x,
/// then about the y of the frame so reached; the ball is the child's orientation in the parent's joint frame. Singular
/// where the rod points along the parent's x: choose frames that keep it away from there.
inline JointType distance_of(const std::vector<double>& values) {
  const double length = values.front();
  return {
      .name = "distance",
      .forbids = {KeepDistance{length}},
      .permits = {Turn{Axis::x}, Turn{Axis::y}, Arm{Axis::z, length}, Ball{}},
      .reads = {BearingOfGap{.about = Axis::x, .from = Axis::z}, ElevationOfGap{.towards = Axis::x}, OrientationOf{}},
      .parameters = {{"length", "m", 0.4}},
      .with_parameters = distance_of,
  };
}
inline const JointType distance = distance_of({0.4});

}  // namespace concord::joints
