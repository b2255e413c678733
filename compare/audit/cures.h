#pragma once

#include <string>
#include <vector>

#include "common/model.h"
#include "common/results.h"

/// Which joints would have to move more freely so that every reaction were unique? Tried type by type, by what the
/// joints permit in one state; no solver is asked.
namespace concord::compare {

/// Another type of a joint whose motion contains the one that the joint has, about the same frames.
struct JointChange {
  int joint = 0;
  const joints::JointType* to = nullptr;
};

struct Cures {
  int redundant = 0;  // number of constraints that say nothing new
  /// Changes, of one joint each or, where no such change helps, of two, with which no constraint is redundant and the
  /// degrees of freedom stay the same.
  std::vector<std::vector<JointChange>> found;
  int tried = 0;
  bool is_complete = true;  // whether all were tried
};

/// Changes that are tried at most: half a second for a machine of forty redundant constraints.
inline constexpr int kMostTries = 2000;

/// Types are those of the catalogue without parameters that hold for positions; a joint keeps the coordinates on which
/// a driver, spring or coupling acts. In the state constraints must not be of lower rank than elsewhere. Nothing is
/// tried where the rank is in doubt.
Cures find_cures(const Model& model, const State& state, int most_tries = kMostTries);

/// "joint B were spherical and joint C cylindrical".
std::string describe(const Model& model, const std::vector<JointChange>& changes);

}  // namespace concord::compare
