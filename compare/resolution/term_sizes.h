#pragma once

#include "common/types.h"
#include "compare/quantities/align.h"
#include "compare/quantities/observe.h"

namespace concord::compare {

/// Size of the terms that a solver adds up to each quantity in a state [the quantity's unit]: the loads on the two
/// bodies of its joint or force element, weight, inertia, strain and every wrench, whatever cancels of them; torques
/// hold forces at the machine's length. Of a body's sum those of its joints; of its accelerations the loads on the body
/// over its mass.
VecX term_sizes(const QuantityLayout& layout, const SharedState& shared);

}  // namespace concord::compare
