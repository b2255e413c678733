#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/joints/named_coordinates.h"
#include "common/model.h"
#include "common/reading/body_reader.h"
#include "common/reading/toml_reader.h"

namespace concord {

/// Reads one `[[joint]]` between the bodies (ground first). Nothing if type or bodies are not known.
std::optional<Joint> read_joint(const toml::table& table, const std::vector<BodyReading>& bodies, FileReading& reading);

/// Complains if the joint to which the table refers as `name` under its key `joint` is none of `joints`, the names of
/// all joints in the model.
void check_joint_name(const TableReader& table, const std::string& name, const std::vector<std::string>& joints);

}  // namespace concord
