#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compare/invariance/change.h"

/// Parent and child of joints and springs change places.
namespace concord::compare::invariance {

/// A change of many parts of a machine, and what of it stays as it is, with the reason.
struct PartialChange {
  Change change;
  int changed = 0;  // parts
  std::vector<std::string> left;
};

/// Swaps parent and child of every joint whose type has a rule for it, with all that acts on its coordinates, and both
/// ends of every line spring. Hinges, slides, balls, crosses and screws read backwards; coordinates of free joints and
/// of links between two balls are read anew from the bodies. `at`: a state of the machine, from which links between two
/// balls take axes that stay away from where their angles have no meaning; without it they stay as they are. What is
/// read anew keeps its numbers at the start: started_in() puts those of a state there.
PartialChange swapped_sides(const Model& model, const std::optional<State>& at);

/// Joint coordinates and speeds as they follow from the bodies.
void read_coordinates(const Joint& joint, const State& bodies, VecX& q, VecX& u);

}  // namespace concord::compare::invariance
