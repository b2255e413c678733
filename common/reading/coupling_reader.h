#pragma once

#include <vector>

#include "common/reading/joint_reader.h"
#include "common/reading/toml_reader.h"

namespace concord {

/// The `[[coupling]]` tables of a model, after its joints. `names` are the names of all joints, of those that could not
/// be read too.
std::vector<Coupling> read_couplings(const TableReader& document, const std::vector<Joint>& joints,
                                     const std::vector<std::string>& names);

}  // namespace concord
