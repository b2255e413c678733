#pragma once

#include "compare/invariance/draw.h"
#include "compare/invariance/sides.h"

namespace concord::compare::invariance {

/// Turns the frames of joints and force elements on both sides as far as what they say allows: of a hinge about its
/// axis by another angle on each side, of a slide by the same one, of a ball in any way. Coordinates then count from
/// elsewhere, and all that acts on them is told anew.
PartialChange turned_joint_frames(const Model& model, Draw& draw);

}  // namespace concord::compare::invariance
