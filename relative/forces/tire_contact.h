#pragma once

#include <string>

#include "common/elements/tire.h"
#include "relative/bodies/joint_point.h"

/// Where and how a tire touches the road, as common/elements/tire.h states it.
namespace concord::relative {

/// The tangent plane of the road below a wheel's centre: normal and directions in it, global axes, and the distance of
/// the centre [m]; and what the scalar laws are said of.
struct ContactFrame {
  Vec3 n = Vec3::UnitZ();
  Vec3 t_x = Vec3::UnitX();
  Vec3 t_y = Vec3::UnitY();
  double D = 0.0;
  TireContact contact;
};

/// The contact of a wheel whose centre and frame are `wheel`, on a stretch of its road. Throws SolverError, with `name`
/// as the tire's, if the spin axis stands within 1e-6 rad on the road (S36), (S37), (R29).
ContactFrame contact_of(const Tire& tire, int stretch, const JointPoint& wheel, const std::string& name);

/// The wrench [F; T] of the forces at the contact, about the wheel's centre, global axes (S39).
Vec6 wrench_at_center(const ContactFrame& frame, const TireForces& forces);

}  // namespace concord::relative
