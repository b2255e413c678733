#pragma once

#include <array>

#include "cartesian/bodies/joint_equations.h"
#include "cartesian/forces/applied_force.h"

/// Springs on the coordinates of one joint: their wrenches, and how far their stops are inside their regimes.
namespace concord::cartesian {

/// Writes coordinate forces and the wrenches on both sides, of a joint that is placed and moved.
void exert_springs(const Joint& stated, const JointEquations& joint, double t, Regimes regimes, AppliedForce& applied);

/// Adds what motors, springs and dampers contribute to the coordinate forces of a joint whose springs have been exerted
/// at time t: of the resistance what is there at rest is the spring's, and the rest the damper's. Only reports ask.
void add_spring_shares(const Joint& stated, const JointEquations& joint, double t, const AppliedForce& applied,
                       std::array<VecX, kActors.size()>& shares);

/// How many event functions the springs of a joint have; 0 if none has regimes.
int n_event_functions(const Joint& stated);

/// Writes how far the springs are inside the regimes of their applied force for this motion, and returns what comes
/// after that.
double* write_event_functions(const Joint& stated, const RelativeMotion& motion, const AppliedForce& applied,
                              double* next);

/// The largest departure of a spring's force, in the regime that is kept, from its law (kLargestDeparture).
double departure_of(const Joint& stated, const RelativeMotion& motion, const AppliedForce& applied);

}  // namespace concord::cartesian
