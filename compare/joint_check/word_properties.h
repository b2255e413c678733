#pragma once

#include <cstdint>
#include <vector>

#include "compare/joint_check/poses.h"
#include "compare/joint_check/property.h"

namespace concord::compare::joint_check {

/// The three statements of a type against each other, and each solver's evaluators against differences and the referee,
/// without any machine: one result for each property, over the given poses of the seed.
Properties check_words(const JointType& type, std::uint32_t seed, const std::vector<int>& poses);

}  // namespace concord::compare::joint_check
