#pragma once

#include <cstddef>

#include "common/model.h"

/// Angles of joints that differ by whole turns: one pose, unless something reads the angle itself.
namespace concord::compare {

/// Whether whole turns of a coordinate of joint `joint` change neither a pose nor a force: it is an angle about an
/// axis, and nothing reads the angle itself: no driver, no coupling, and no spring or stop of the joint.
bool whole_turns_change_nothing(const Model& model, std::size_t joint, int word, int component);

/// The angle that differs from `angle` by whole turns and is nearest to `near` [rad].
double with_turns_of(double near, double angle);

}  // namespace concord::compare
