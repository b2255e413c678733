#pragma once

#include <string>
#include <vector>

#include "common/joints/joint_type.h"

/// Joints that leave some of the six axes free and hold the others, each in the words that exist: planar, point on a
/// plane or on a line, and their kin.
namespace concord::joints {

/// Some of the three axes.
struct Axes {
  bool x = false;
  bool y = false;
  bool z = false;

  [[nodiscard]] std::vector<Axis> list() const {
    std::vector<Axis> all;
    if (x) all.push_back(Axis::x);
    if (y) all.push_back(Axis::y);
    if (z) all.push_back(Axis::z);
    return all;
  }
  [[nodiscard]] std::string name() const {
    return x || y || z ? std::string(x ? "x" : "") + (y ? "y" : "") + (z ? "z" : "") : "none";
  }
};

/// What is said of the orientation: none, one (the axis is shared), two (they stay at right angles, the first on the
/// parent, the last on the child), or all.
inline void add_turns(const std::vector<Axis>& turns, JointType& type) {
  const auto next = [](Axis axis) { return static_cast<Axis>((index(axis) + 1) % 3); };
  if (turns.empty()) {
    type.forbids.emplace_back(SameOrientation{});
  } else if (turns.size() == 1) {
    const Axis axis = turns.front();
    type.forbids.emplace_back(SameDirection{axis});
    type.permits.emplace_back(Turn{axis});
    type.reads.emplace_back(TurnOfChildAxis{.about = axis, .of_child_axis = next(axis)});
  } else if (turns.size() == 2) {
    const Axis first = turns.front();
    const Axis last = turns.back();
    type.forbids.emplace_back(Perpendicular{.on_parent = first, .on_child = last});
    type.permits.insert(type.permits.end(), {Turn{first}, Turn{last}});
    type.reads.emplace_back(TurnOfChildAxis{.about = first, .of_child_axis = last});
    type.reads.emplace_back(TurnOfParentAxis{.about = last, .of_parent_axis = first});
  } else {
    type.permits.emplace_back(Ball{});
    type.reads.emplace_back(OrientationOf{});
  }
}

/// The joint that slides along some axes of its parent and turns about others, in this order.
inline JointType with_free_axes(const Axes& slides, const std::vector<Axis>& turns) {
  JointType type;
  for (const Axis axis : slides.list()) {
    type.permits.emplace_back(Slide{axis});
    type.reads.emplace_back(SlideAlong{axis});
  }
  if (slides.list().empty()) type.forbids.emplace_back(Coincide{});
  for (const Axis axis : Axes{!slides.x, !slides.y, !slides.z}.list()) {
    if (!slides.list().empty()) type.forbids.emplace_back(NoGapAlong{axis});
  }
  add_turns(turns, type);
  return type;
}

inline JointType with_free_axes(const Axes& slides, const Axes& turns) {
  JointType type = with_free_axes(slides, turns.list());
  type.name = "slides_" + slides.name() + "_turns_" + turns.name();
  return type;
}

inline const JointType planar = with_free_axes({.x = true, .y = true}, Axes{.z = true});

/// All 64.
inline std::vector<JointType> with_any_free_axes() {
  std::vector<JointType> all;
  const auto axes = [](int set) { return Axes{(set & 1) != 0, (set & 2) != 0, (set & 4) != 0}; };
  for (int slides = 0; slides < 8; ++slides) {
    for (int turns = 0; turns < 8; ++turns) all.push_back(with_free_axes(axes(slides), axes(turns)));
  }
  return all;
}

}  // namespace concord::joints
