#include "relative/forces/tire_contact.h"

#include <fmt/format.h>

#include <cmath>

namespace concord::relative {

namespace {

constexpr double kFlat = 1e-6;  // |a x n|

}  // namespace

ContactFrame contact_of(const Tire& tire, int stretch, const JointPoint& wheel, const std::string& name) {
  const RoadHeight road = evaluate(*tire.road, stretch, wheel.r.x());
  const double n_z = 1.0 / std::hypot(1.0, road.slope);
  const double n_z_dot = -road.slope * road.curvature * wheel.v.x() * n_z * n_z * n_z;
  const double above = wheel.r.z() - road.h;

  ContactFrame frame;
  frame.n = Vec3(-road.slope * n_z, 0.0, n_z);
  frame.D = above * n_z;
  const Vec3 ahead = wheel.A.col(index(Axis::y)).cross(frame.n);
  if (!(ahead.norm() > kFlat)) {
    throw SolverError(
        fmt::format("relative: force element '{}': the wheel lies flat on the road, so that it has no direction: its "
                    "spin axis must not stand on the road",
                    name));
  }
  frame.t_x = ahead.normalized();
  frame.t_y = frame.n.cross(frame.t_x);

  TireContact& contact = frame.contact;
  contact.x = wheel.r.x();
  contact.delta = tire.radius - frame.D;
  contact.deltadot = -((wheel.v.z() - road.slope * wheel.v.x()) * n_z + above * n_z_dot);
  contact.V_x = wheel.v.dot(frame.t_x);
  contact.V_y = wheel.v.dot(frame.t_y);
  contact.s_x = (wheel.v - frame.D * wheel.omega.cross(frame.n)).dot(frame.t_x);
  return frame;
}

Vec6 wrench_at_center(const ContactFrame& frame, const TireForces& forces) {
  const Vec3 force = forces.N * frame.n + forces.F_x * frame.t_x + forces.F_y * frame.t_y;
  Vec6 w;
  w << force, (-frame.D * frame.n).cross(force);
  return w;
}

}  // namespace concord::relative
