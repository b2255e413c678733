#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "common/model.h"

/// Which of two neighbours is nearer to the ground, by all joints: a tree that cuts some may say otherwise.
namespace concord::compare {

/// Bodies between each body and the ground, the fewest there are; the ground has -1.
std::vector<int> depths(const Model& model);

/// The bodies of a joint, the one nearer to the ground first; nothing where that is the ground, or where both are as
/// far.
std::optional<std::pair<int, int>> near_and_far(const Joint& joint, const std::vector<int>& depth);

}  // namespace concord::compare
