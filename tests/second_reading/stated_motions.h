#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/joints/by_function.h"

/// What data/format/joints.md says of the motion of each joint type.
namespace concord::second_reading {

/// Where the child stands with the coordinates q of a joint type that has these numbers (length, lead, radius), seen
/// from the parent's joint frame; nothing for a type that the page does not have.
std::optional<joints::Placement> stated_placement(const std::string& type, const std::vector<double>& numbers,
                                                  const VecX& q);

/// Of the types that forbid speeds alone.
struct StatedSpeeds {
  int n = 0;       // how many are free
  MatX forbidden;  // rows over [ddot; omega_rel] that vanish, in the parent's joint frame
};

/// The same of its speeds where the child stands turned by R; nothing for a type all of whose speeds are free.
std::optional<StatedSpeeds> stated_speeds(const std::string& type, const std::vector<double>& numbers, const Mat3& R);

}  // namespace concord::second_reading
