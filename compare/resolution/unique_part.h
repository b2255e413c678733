#pragma once

#include <optional>

#include "common/model.h"
#include "common/results.h"
#include "compare/quantities/agreement.h"

/// What of a run the machine determines, and what is one of many values that fit as well.
namespace concord::compare {

/// A direction has no part along an axis below this: round-off of a rotation.
inline constexpr double kNoPart = 1e-12;

/// A run in which NaN stands in the place of every number that is not unique in its sample: of reactions and total
/// wrenches on both sides, of forces on joint speeds and of couplings. `unique` (rows: quantities of the layout,
/// columns: the samples of the run) says what is. A component along a global axis is left out where one of the joint's
/// frame that is not unique has a part along that axis. What a joint cannot carry is zero, and stays. Nothing where
/// every number is unique.
std::optional<Trajectory> unique_part(const Model& model, const Trajectory& run, const Mask& unique);

}  // namespace concord::compare
