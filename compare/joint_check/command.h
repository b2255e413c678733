#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compare/report/console.h"

namespace concord::compare::joint_check {

struct JointCommand {
  std::vector<std::string> names = {};
  bool all = false;  // every type of the catalogue
  std::uint32_t seed = 19971025;
  int poses = 20;
  std::optional<int> pose = {};    // only this one
  std::filesystem::path out = {};  // folder for JOINT.sheet.txt and JOINT.sheet.json; empty: none
};

/// Checks joint types and prints their sheets, with several a summary. Returns 0 if all properties hold, 1 if any
/// fails, 2 for a name that the catalogue does not have. Types are checked side by side on all processors.
int check_joints(const JointCommand& command, const Console& console);

}  // namespace concord::compare::joint_check
