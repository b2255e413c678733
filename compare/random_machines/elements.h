#pragma once

#include <string>
#include <vector>

#include "compare/random_machines/laws.h"
#include "compare/random_machines/machine.h"
#include "compare/random_machines/random.h"

namespace concord::compare::fuzz {

/// Places drawn for an element: between two bodies, or on one alone, which moves.
struct Ends {
  End parent;
  End child;
  End alone;
};

/// An element of element_keys()[kind] on a machine in these poses: ends of springs apart, frames that resist
/// turning near one another, a tire pressed into its road.
ElementPlan draw_element(int kind, const Ends& ends, const std::vector<Pose>& poses, const Units& units,
                         Random& random);

}  // namespace concord::compare::fuzz
