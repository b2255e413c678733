#pragma once

#include <cstdint>
#include <vector>

#include "compare/joint_check/poses.h"
#include "compare/joint_check/property.h"

/// What is checked of a joint type by itself, without any machine.
namespace concord::compare::joint_check {

/// Whether the type is a joint at all: numbers that must fit before anything can be evaluated. A type that fails here
/// can be checked no further.
Properties check_statement(const JointType& type);

/// The three statements of a type against each other, and each solver's evaluators against differences and the referee,
/// without any machine: one result for each property, over the given poses of the seed.
Properties check_words(const JointType& type, std::uint32_t seed, const std::vector<int>& poses);

}  // namespace concord::compare::joint_check
