#pragma once

#include <string>

#include "common/model.h"
#include "common/results.h"

/// Motions of a machine in the words of its joints.
namespace concord::compare {

/// How a change of the machine looks, in the joint coordinates that take part most: "hinge turn_z", "A turn_z and B
/// slide_x"; bodies if no joint moves; "nothing" if all is zero. `velocities`: [v; omega; adot] of bodies 1, 2, ... in
/// SI units; their size does not matter.
std::string describe_motion(const Model& model, const State& state, const VecX& velocities);

/// Combines motions (columns of velocities) so that each has one joint speed to itself, as far as joints tell them
/// apart: slide_x of the chassis, turn_z of a wheel, instead of mixtures.
MatX separate_motions(const Model& model, const State& state, MatX motions);

}  // namespace concord::compare
