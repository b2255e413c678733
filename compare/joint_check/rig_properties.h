#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "compare/joint_check/poses.h"
#include "compare/joint_check/property.h"

namespace concord::compare::joint_check {

/// Agreement of the Cartesian solver with the relative one, tree joint and cut joint, in every way of building the type
/// in: a row for each pair of rigid and flexible bodies, a column for each load of the joint and each rig.
struct WrenchTable {
  static constexpr int kPairs = 4;
  static constexpr int kLoads = 5;
  static constexpr int kRigs = 2;

  static const std::array<std::string, kPairs>& pair_names();  // "rigid - rigid", ...
  static const std::array<std::string, kLoads>& load_names();  // "free", "sprung", ...
  static const std::array<std::string, kRigs>& rig_names();    // "open", "closed"

  /// Row by row; a property that was not looked at means that the type has no coordinate to load.
  std::vector<Property> cells;

  [[nodiscard]] const Property& at(int pair, int load, int rig) const {
    return cells[(pair * kLoads + load) * kRigs + rig];
  }
};

struct RigFindings {
  Properties properties;
  WrenchTable wrenches;
};

/// The type between two bodies, through both solvers: states, turns, rank, wrenches, audits; over the given poses of
/// the seed.
RigFindings check_in_rigs(const JointType& type, std::uint32_t seed, const std::vector<int>& poses);

}  // namespace concord::compare::joint_check
