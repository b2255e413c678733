#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/joints/joint_type.h"

namespace concord {

/// A coordinate of a joint that model files can name: a turn, a slide, a whole ball, or one number of a motion by
/// functions.
struct NamedCoordinate {
  std::string name;   // "slide_z", "turn_x", "ball"; the second of the same name is "turn_x2"
  int word = 0;       // of the type's motion
  int component = 0;  // of the word's coordinates
  int place = 0;      // in the list of all named coordinates
  joints::CoordinateKind kind{};
  std::optional<Axis> axis = {};  // see joints::StatedCoordinate
};

/// The named coordinates of a type in the order of its motion. An arm has none.
std::vector<NamedCoordinate> named_coordinates(const joints::JointType& type);

}  // namespace concord
