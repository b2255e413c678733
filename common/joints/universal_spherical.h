#pragma once

#include "common/joints/joint_type.h"

namespace concord::joints {

/// A link without mass on a cross at the parent, with a ball on the child. The cross turns about the parent's y, the
/// link about the cross's z; the link points along x of the frame so reached. Because the link is at right angles to
/// its axis on the cross, it carries no torque: what it forbids is what a distance joint forbids, but its two angles
/// are those of a real cross, on which springs, motors and drivers may act. q = (turn_y, turn_z, ball); the ball is the
/// child's orientation in the parent's joint frame. Singular where the link points along the parent's y.
inline JointType universal_spherical_of(const std::vector<double>& values) {
  const double length = values.front();
  return {
      .name = "universal_spherical",
      .forbids = {KeepDistance{length}},
      .permits = {Turn{Axis::y}, Turn{Axis::z}, Arm{Axis::x, length}, Ball{}},
      .reads = {BearingOfGap{.about = Axis::y, .from = Axis::x}, ElevationOfGap{.towards = Axis::y}, OrientationOf{}},
      .parameters = {{"length", "m", 0.4}},
      .with_parameters = universal_spherical_of,
  };
}
inline const JointType universal_spherical = universal_spherical_of({0.4});

}  // namespace concord::joints
