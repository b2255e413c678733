#pragma once

#include "cartesian/bodies/constraints.h"
#include "cartesian/forces/applied_forces.h"
#include "common/results.h"

namespace concord::cartesian {

/// The springs of a joint, exerted at time t.
struct SpringsAt {
  double t;
  const AppliedForce& exerted;
};

/// Wrenches of joint k from the multipliers of its rows and its coupled coordinates (joint_multipliers()), (C41)
/// and (C43): on either side from that body's own columns of the Jacobian, F = -Phi_r^T lambda at the side's point and
/// T = -Phi_pi^T lambda - (A s_P) x F. The reaction is the wrench of the joint's rows minus the coordinate wrenches of
/// drivers and couplings (tau = -lambda); the total is the wrench of the rows plus that of the joint's springs
/// (nullptr: it has none). Of tau the drivers' share is what their own multipliers say.
JointWrenches compute_wrenches(const Joint& stated, const JointEquations& joint, const Eigen::Ref<const VecX>& lambda,
                               const SpringsAt* springs);
/// The same where there were others of the same joint: allocates nothing.
void write_wrenches(const Joint& stated, const JointEquations& joint, const Eigen::Ref<const VecX>& lambda,
                    const SpringsAt* springs, JointWrenches& wrenches);

}  // namespace concord::cartesian
