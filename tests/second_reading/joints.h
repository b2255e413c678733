#pragma once

#include "common/model.h"
#include "tests/second_reading/stated_table.h"

namespace concord::second_reading {

/// One coordinate of a joint as files name it: the second of the same name has a 2 behind it.
struct JointCoordinate {
  std::string name;
  int word = 0;
  int component = 0;
  joints::CoordinateKind kind{};
};
std::vector<JointCoordinate> coordinates_of(const joints::JointType& type);

/// What `[[joint]]` states.
void hold_joint(const Model& model, const Joint& joint, const StatedTable& table);

/// The type of a joint with its own parameters.
void hold_joint_type(const Joint& joint, const StatedTable& table);

/// What `start` of a joint states.
void hold_start_of_joint(const Joint& joint, const StatedTable& table);

/// What `[[coupling]]` states.
void hold_coupling(const Model& model, const Coupling& coupling, const StatedTable& table);

}  // namespace concord::second_reading
