#include "common/joints/joint_type.h"

#include <algorithm>

#include "common/overloaded.h"

namespace concord::joints {

namespace {

struct Directions {
  std::vector<Axis> slides;
  std::vector<Axis> turns;
  bool arm = false;
  bool ball = false;
  bool by_functions = false;  // or in any other way of which no axis is stated
};

void add_coordinate(const StatedCoordinate& coordinate, Directions& found) {
  switch (coordinate.kind) {
    case CoordinateKind::orientation:
      found.ball = true;
      return;
    case CoordinateKind::angle:
      if (coordinate.axis) found.turns.push_back(*coordinate.axis);
      break;
    case CoordinateKind::length:
      if (coordinate.axis) found.slides.push_back(*coordinate.axis);
      break;
  }
  if (!coordinate.axis) found.by_functions = true;
}

Directions directions_of(const JointType& type) {
  Directions found;
  for (const Permit& word : type.permits) {
    for (const StatedCoordinate& coordinate : stated_coordinates(word)) add_coordinate(coordinate, found);
    if (arm_of(word)) found.arm = true;
  }
  return found;
}

bool all_are(const std::vector<Axis>& axes, Axis axis) {
  return std::all_of(axes.begin(), axes.end(), [axis](Axis other) { return other == axis; });
}

bool slides_everywhere(const Directions& permitted) { return permitted.slides.size() == 3; }

/// On the parent the torque is taken at P_j, so that a gap d adds d x F: without effect along the axis only if the
/// joint slides along nothing else.
bool gap_has_no_lever(const Directions& permitted, Side side, Axis axis) {
  return side == Side::child || all_are(permitted.slides, axis) || slides_everywhere(permitted);
}

bool carries_force(const Directions& permitted, Side side, Axis axis) {
  if (permitted.by_functions) return true;
  if (slides_everywhere(permitted)) return false;
  const bool slides = std::count(permitted.slides.begin(), permitted.slides.end(), axis) > 0;
  const bool frames_share_axis = side == Side::parent || (!permitted.ball && all_are(permitted.turns, axis));
  return !(slides && frames_share_axis);
}

bool carries_torque(const Directions& permitted, Side side, Axis axis) {
  if (permitted.by_functions) return true;
  if (permitted.arm && side == Side::parent) {
    // A link without mass turns about its axes at P_j: no torque about them. Two of them and the link itself are three.
    return permitted.turns.size() == 1 && permitted.turns.front() != axis;
  }
  if (!gap_has_no_lever(permitted, side, axis)) return true;
  if (permitted.ball) return false;
  if (permitted.turns.empty()) return true;
  const Axis own = side == Side::parent ? permitted.turns.front() : permitted.turns.back();
  return own != axis;
}

/// Whether a frame of that side has the axis of a direction of velocities: its own, or one that the sides share.
bool has_axis(const Directions& permitted, Side side, Axis axis, Side axis_of) {
  return side == axis_of || (!permitted.ball && all_are(permitted.turns, axis));
}

/// Whether the velocity alone has a direction at every pose along which the component would work. A rotation about a
/// point below the joint point does so only about the line through both.
bool moves_along(const JointType& type, Side side, int component) {
  const Directions permitted = directions_of(type);
  const auto axis = static_cast<Axis>(component % 3);
  const auto is_it = Overloaded{
      [&](const SpeedAlong& along) {
        return component < 3 && along.axis == axis && has_axis(permitted, side, axis, along.axis_of);
      },
      [&](const SpeedAbout& about) {
        const bool through_point = about.below == 0.0 || (about.axis == Axis::z && about.axis_of == Side::parent);
        return component >= 3 && about.axis == axis && through_point &&
               has_axis(permitted, side, axis, about.axis_of) && gap_has_no_lever(permitted, side, axis);
      }};
  return std::any_of(type.permits_speeds.begin(), type.permits_speeds.end(),
                     [&](const PermitSpeed& word) { return std::visit(is_it, word); });
}

}  // namespace

int JointType::rows() const {
  int count = 0;
  for (const Forbid& word : forbids) count += joints::rows(word);
  return count;
}

int JointType::nonholonomic_rows() const {
  int count = 0;
  for (const ForbidSpeed& word : forbids_speeds) count += joints::rows(word);
  return count;
}

int JointType::n_q() const {
  int count = 0;
  for (const Permit& word : permits) count += joints::n_q(word);
  return count;
}

int JointType::n_u() const {
  int count = 0;
  for (const Permit& word : permits) count += joints::n_u(word);
  return count;
}

bool carries(const JointType& type, Side side, int component) {
  if (!type.permits_speeds.empty()) return !moves_along(type, side, component);
  const Directions permitted = directions_of(type);
  const auto axis = static_cast<Axis>(component % 3);
  return component < 3 ? carries_force(permitted, side, axis) : carries_torque(permitted, side, axis);
}

}  // namespace concord::joints
