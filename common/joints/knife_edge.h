#pragma once

#include "common/joints/joint_type.h"

namespace concord::joints {

/// A skate on ice. The child stands on the parent's plane z = 0 and turns about the parent's z. Its joint point cannot
/// move along the child's y: the edge lies along the child's x. q = (place in the parent's x and y [m], angle about z
/// [rad]), free in all three; of their speeds only two are: along the edge, and turning. Never singular.
inline const JointType knife_edge{
    .name = "knife_edge",
    .forbids = {NoGapAlong{Axis::z}, SameDirection{Axis::z}},
    .permits = {Slide{Axis::x}, Slide{Axis::y}, Turn{Axis::z}},
    .reads = {SlideAlong{Axis::x}, SlideAlong{Axis::y}, TurnOfChildAxis{.about = Axis::z, .of_child_axis = Axis::x}},
    .forbids_speeds = {NoSlip{.axis_of = Side::child, .axis = Axis::y}},
    .permits_speeds = {SpeedAlong{.axis_of = Side::child, .axis = Axis::x},
                       SpeedAbout{.axis_of = Side::parent, .axis = Axis::z}},
};

}  // namespace concord::joints
