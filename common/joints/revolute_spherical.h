#pragma once

#include "common/joints/joint_type.h"

namespace concord::joints {

/// A link without mass, hinged to the parent about its z, with a ball on the child: the ball's centre stays on a circle
/// in the parent's xy plane. q = (turn_z, ball): the link points along the parent's x, turned about z; the ball is the
/// child's orientation in the parent's joint frame. Never singular.
inline JointType revolute_spherical_of(const std::vector<double>& values) {
  const double length = values.front();
  return {
      .name = "revolute_spherical",
      .forbids = {KeepDistance{length}, NoGapAlong{Axis::z}},
      .permits = {Turn{Axis::z}, Arm{Axis::x, length}, Ball{}},
      .reads = {BearingOfGap{.about = Axis::z, .from = Axis::x}, OrientationOf{}},
      .parameters = {{"length", "m", 0.4}},
      .with_parameters = revolute_spherical_of,
  };
}
inline const JointType revolute_spherical = revolute_spherical_of({0.4});

}  // namespace concord::joints
