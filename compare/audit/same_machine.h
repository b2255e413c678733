#pragma once

#include <string>

#include "common/model.h"

/// Two descriptions of a machine in other frames: are they of one machine? Where concord itself describes a model anew
/// before it computes, what it made of the model is held against the model as it was read.
namespace concord::compare {

/// What of `changed` is farthest from what `given` says at the start pose: "mass centre of body 'leaf': off by 20 m,
/// allowed 4.1e-11 m". Empty if body by body mass, mass centre, inertia, modal data and beam, and in the world the
/// places and axes of every attachment, node and mass point, are equal to 1e-12 of the distances involved, and loads to
/// 1e-12 of themselves. `world`: where the world's origin of `changed` lies in that of `given` [m].
std::string difference_of_machines(const Model& given, const Model& changed, const Vec3& world);

}  // namespace concord::compare
