#pragma once

#include "common/joints/joint_type.h"

namespace concord::joints {

/// A ball of radius `radius` on a rough plane: the child's joint point is its centre and stays in the parent's plane
/// z = 0, so the plane that it rolls on lies `radius` below. The ball's lowest point does not slip over the parent.
/// q = (place in the parent's x and y [m], orientation); of the five speeds three are free: rolling about the parent's
/// x and y, and spinning about z. Never singular.
inline JointType rolling_ball_of(const std::vector<double>& values) {
  const double radius = values.front();
  return {
      .name = "rolling_ball",
      .forbids = {NoGapAlong{Axis::z}},
      .permits = {Slide{Axis::x}, Slide{Axis::y}, Ball{}},
      .reads = {SlideAlong{Axis::x}, SlideAlong{Axis::y}, OrientationOf{}},
      .parameters = {{"radius", "m", 0.25}},
      .with_parameters = rolling_ball_of,
      .forbids_speeds = {NoSlip{.axis_of = Side::parent, .axis = Axis::x, .below = radius},
                         NoSlip{.axis_of = Side::parent, .axis = Axis::y, .below = radius}},
      .permits_speeds = {SpeedAbout{.axis_of = Side::parent, .axis = Axis::x, .below = radius},
                         SpeedAbout{.axis_of = Side::parent, .axis = Axis::y, .below = radius},
                         SpeedAbout{.axis_of = Side::parent, .axis = Axis::z}},
  };
}
inline const JointType rolling_ball = rolling_ball_of({0.25});

}  // namespace concord::joints
