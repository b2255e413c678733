#pragma once

#include "compare/invariance/draw.h"
#include "compare/invariance/sides.h"

/// Bodies in two parts that a weld holds together. A part of a flexible body would have to move with its modes: such
/// bodies stay whole.
namespace concord::compare::invariance {

/// Between a joint and one of its bodies a part of that body, or of ground a body of its own, is welded in: of every
/// joint that has a rigid body or ground on a side.
PartialChange with_welds(const Model& model, Draw& draw);

/// Every rigid body is split in two: the new one takes every second of its joints and force elements and a part of its
/// mass.
PartialChange split_bodies(const Model& model, Draw& draw);

}  // namespace concord::compare::invariance
