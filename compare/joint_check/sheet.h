#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compare/joint_check/rig_properties.h"

/// All that was found about one joint type, and how it is said.
namespace concord::compare::joint_check {

struct SheetOptions {
  std::uint32_t seed = 19971025;
  std::vector<int> poses;  // numbers of the poses of that seed; at least one
};

struct Sheet {
  std::string joint;
  int rows = 0;
  int nonholonomic_rows = 0;             // of velocities alone
  std::vector<std::string> coordinates;  // "turn_x", "slide_z", "ball"
  SheetOptions options;
  Properties properties;
  WrenchTable wrenches;

  [[nodiscard]] bool holds() const;
  /// Properties that were looked at, cells of the table of wrenches among them, and how many of those hold.
  [[nodiscard]] int looked() const;
  [[nodiscard]] int held() const;
};

/// Checks one type. If its statement is none, that is all that the sheet says.
Sheet check_joint(const JointType& type, const SheetOptions& options);

/// The sheet as text: what was checked, the table of properties, the table of wrenches, each failure in plain words
/// with the command that reproduces it, and a last line.
std::string format_sheet(const Sheet& sheet);

/// One row for each sheet.
std::string format_summary(const std::vector<Sheet>& sheets);

/// The sheet as JSON, indented, ending with a line feed: format, joint, verdict ("holds", "fails"), seed, poses,
/// properties[] with name, looked, digits, need (null: holds or not), holds, pose (null: none in particular), where.
std::string format_sheet_json(const Sheet& sheet);

}  // namespace concord::compare::joint_check
