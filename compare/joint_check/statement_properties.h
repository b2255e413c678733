#pragma once

#include "common/joints/joint_type.h"
#include "compare/joint_check/property.h"

namespace concord::compare::joint_check {

/// Whether the type is a joint at all: numbers that must fit before anything can be evaluated. A type that fails here
/// can be checked no further.
Properties check_statement(const joints::JointType& type);

}  // namespace concord::compare::joint_check
