#pragma once

#include "common/types.h"
#include "compare/verdict/align.h"
#include "compare/verdict/observe.h"

namespace concord::compare {

/// Size of the terms that a solver adds up to each quantity in a state [the quantity's unit]: loads of the bodies, and
/// what passes through their joints.
VecX term_sizes(const QuantityLayout& layout, const SharedState& shared);

}  // namespace concord::compare
