#pragma once

#include <vector>

#include "compare/invariance/change.h"

/// Where the frames of the bodies and of the world lie.
namespace concord::compare::invariance {

/// Moves and turns the frame of every body in the body; frames[0], ground's, is not used.
Change with_body_frames(const std::vector<Pose>& frames);

/// How far the world may be turned and moved: a road is the same at every y and has its height along z, so that under
/// tires the world keeps its vertical, and above a road that is not flat it keeps its x too.
struct WorldFreedom {
  bool turns = true;  // about every axis
  bool turns_about_vertical = true;
  bool rises = true;
};
WorldFreedom freedom_of_world(const Model& model);

/// Moves and turns everything, gravity, roads and what stands on ground included: r' = world.r + world.A r. The model
/// must leave this freedom.
Change in_world(const Pose& world);

}  // namespace concord::compare::invariance
