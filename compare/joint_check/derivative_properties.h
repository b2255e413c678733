#pragma once

#include "compare/joint_check/evaluated_pose.h"
#include "compare/joint_check/property.h"

/// The derivatives that both solvers compute of the words, against central differences and against the referee's.
namespace concord::compare::joint_check {

/// Four properties: Jacobian and gamma of what is forbidden, then of what reads.
void rows_against_differences(const EvaluatedPose& evaluated, Property* properties);

/// Columns S of the motion, and their rates Sdot u.
void motion_against_differences(const EvaluatedPose& evaluated, Property& columns, Property& rates);

/// Gradients and biases of what is forbidden and of what reads.
void rows_against_referee(const EvaluatedPose& evaluated, Property& forbidden, Property& readings);

/// d, R, S, S u and Sdot u of the motion.
void motion_against_referee(const EvaluatedPose& evaluated, Property& property);

}  // namespace concord::compare::joint_check
