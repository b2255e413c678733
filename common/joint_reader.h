#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/body_reader.h"
#include "common/model.h"
#include "common/toml_reader.h"

namespace concord {

/// A coordinate of a joint that model files can name: a turn, a slide, a whole ball, or one number of a motion by
/// functions.
struct NamedCoordinate {
  std::string name;   // "slide_z", "turn_x", "ball"; the second of the same name is "turn_x2"
  int word = 0;       // of the type's motion
  int component = 0;  // of the word's coordinates
  int place = 0;      // in the list of all named coordinates
};

/// The named coordinates of a type in the order of its motion. An arm has none.
std::vector<NamedCoordinate> named_coordinates(const joints::JointType& type);

/// Reads one `[[joint]]` between the bodies (ground first). Nothing if type or bodies are not known.
std::optional<Joint> read_joint(const toml::table& table, const std::vector<BodyReading>& bodies, FileReading& reading);

/// Complains if the joint to which the table refers as `name` under its key `joint` is none of `joints`, the names of
/// all joints in the model.
void check_joint_name(const TableReader& table, const std::string& name, const std::vector<std::string>& joints);

}  // namespace concord
