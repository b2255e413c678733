#pragma once

#include "relative/articulated_inertias.h"

namespace concord::relative {

/// A motion of a link's joint: its speeds.
struct MotionWithoutInertia {
  LinkIndex link;
  JointVector u;
};

/// The outermost link of the opened tree whose joint can move without inertia, and the joint's speeds u (n_u) in that
/// motion, driven ones at rest; also of inertias whose computation threw. "Without" means below round-off of the terms
/// that the inertia is made of.
[[nodiscard]] std::optional<MotionWithoutInertia> find_motion_without_inertia(const ArticulatedInertias& tree);

}  // namespace concord::relative
