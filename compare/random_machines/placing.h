#pragma once

#include <string>
#include <vector>

#include "compare/random_machines/machine.h"

/// Puts a machine into its pose, closes its loops there and finds what its start can keep.
namespace concord::compare::fuzz {

struct Placing {
  std::vector<Pose> poses;  // of all bodies, ground first
  std::string trouble;      // why it cannot start; empty if it can
  [[nodiscard]] bool ok() const { return trouble.empty(); }
};

/// Poses of all bodies from the joints of the tree, modes undeformed.
std::vector<Pose> poses_of(const Machine& machine);

/// Driven coordinates go where their laws are at the start; the child's end of each joint that closes a loop is put
/// where it closes exactly; offsets of couplings follow; the coordinates and speeds that the start keeps are chosen in
/// an order drawn from `choice`; all other speeds are solved for. Trouble if constraints depend on each other and the
/// machine is not meant to be redundant, if drivers or couplings depend on the joints, if the pose is near a singular
/// one, or if whole words do not make up the degrees of freedom.
Placing place(Machine& machine, std::uint64_t choice);

}  // namespace concord::compare::fuzz
