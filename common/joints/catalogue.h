#pragma once

#include <string_view>
#include <vector>

#include "common/joints/joint_type.h"

namespace concord::joints {

/// All joint types of the program, those of pages outside the project last. A new type is one page in this folder and
/// one line in catalogue.cpp, or one page anywhere else and the CMake option CONCORD_EXTRA_JOINTS.
const std::vector<const JointType*>& catalogue();

/// The types of the pages that CONCORD_EXTRA_JOINTS names.
std::vector<const JointType*> extra_types();

/// The type of that name, or nullptr.
const JointType* find(std::string_view name);

}  // namespace concord::joints
