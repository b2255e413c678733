#pragma once

#include <string>
#include <vector>

#include "compare/random_machines/laws.h"
#include "compare/random_machines/machine.h"
#include "compare/random_machines/random.h"

namespace concord::compare::fuzz {

/// Tables of all force elements.
const std::vector<std::string>& element_tables();

/// Places drawn for an element: between two bodies, or on one alone, which moves.
struct Ends {
  End parent;
  End child;
  End alone;
};

/// An element of element_tables()[kind] on a machine in these poses: ends of springs apart, frames of bushings near one
/// another, a tire pressed into its road.
ElementPlan draw_element(int kind, const Ends& ends, const std::vector<Pose>& poses, const Units& units,
                         Random& random);

}  // namespace concord::compare::fuzz
