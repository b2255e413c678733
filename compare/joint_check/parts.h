#pragma once

#include <string>

#include "common/model.h"
#include "compare/joint_check/poses.h"

/// Generic parts of the rigs: nothing lies on an axis, nothing is equal, nothing is one.
namespace concord::compare::joint_check {

Body rigid_body(const std::string& name, Numbers& numbers);

/// A cloud of eleven mass points with m modes that are not aligned with anything; full stiffness and damping matrices.
Body flexible_body(const std::string& name, int m, Numbers& numbers);

/// A joint at random places whose words start at q and u, all with the same role.
Joint joint(const Model& model, const std::string& name, const JointType& type, int parent, int child, const VecX& q,
            const VecX& u, StartRole role, Numbers& numbers);

/// q of a free joint: a place and an orientation.
VecX free_q(Numbers& numbers);

}  // namespace concord::compare::joint_check
