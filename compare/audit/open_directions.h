#pragma once

#include "common/types.h"
#include "compare/audit/machine_rank.h"

/// In which directions do redundant constraints leave a joint's force, or its torque, open? What is across them is
/// unique, whether or not the axes of a frame lie so.
namespace concord::compare {

/// Of the force (part 0) or the torque (part 1) of one joint's reaction on one side, in that side's joint frame.
struct OpenDirections {
  Mat3X directions;    // orthonormal columns: along them self-stresses move it
  int carried = 0;     // number of independent directions in which the joint can carry it in this state
  double doubt = 0.0;  // by how much the directions may be off: round-off of the constraints and of their rank [rad]
  /// Whether their number is the same for another threshold, self-stresses move it clearly along each of them, and the
  /// doubt is small.
  bool is_clear = true;

  /// On what is unique.
  [[nodiscard]] Mat3 projector() const;
};

OpenDirections open_directions(const MachineConstraints& constraints, int joint, Side side, int part);

}  // namespace concord::compare
