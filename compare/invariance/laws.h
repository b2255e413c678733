#pragma once

#include "common/laws/coupling.h"
#include "common/laws/force_law.h"
#include "common/laws/time_function.h"
#include "common/model.h"

/// Laws of time and of force, told of another coordinate.
namespace concord::compare::invariance {

/// The law `value` times as large, in which times are `time` times as long.
TimeFunction scaled(const TimeFunction& law, double value, double time = 1.0);
/// The law plus a constant.
TimeFunction shifted(const TimeFunction& law, double by);
/// Abscissae and values of a table times factors; negative ones turn it round.
SplineTable scaled(const SplineTable& table, double x, double y);

/// The law that resists -x as `law` resists x.
ForceLaw mirrored(ForceLaw law);
/// The law that resists x + by as `law` resists x.
ForceLaw shifted(ForceLaw law, double by);

/// Tells all that acts on one coordinate of joint k (drivers, springs, couplings) of the coordinate plus a constant.
void shift_coordinate(Model& model, int k, int word, int component, double by);

}  // namespace concord::compare::invariance
