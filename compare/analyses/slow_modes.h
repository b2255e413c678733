#pragma once

#include "compare/analyses/eigenmodes.h"

/// Modes that are hardly faster than what differences tell from zero.
namespace concord::compare::analyses {

/// Brings modes that the search for eigenvalues has left open to where they solve their equations. One that clearly
/// does not solve them, or does so where another one does, is not resolved: that is written into it.
void refine_slow_modes(const Chart& chart, const MotionMatrices& matrices, FoundModes& found);

}  // namespace concord::compare::analyses
