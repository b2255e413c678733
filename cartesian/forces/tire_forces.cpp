#include "cartesian/forces/tire_forces.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace concord::cartesian {

namespace {

/// A tire above the tangent plane of its road: unit vectors, the centre's distance from the plane, and the contact.
struct TireOnRoad {
  Vec3 normal;
  Vec3 forward;
  Vec3 sideways;
  double distance;
  TireContact contact;
};

/// Throws SolverError where the spin axis is normal to the road (S36), (S37), (C37).
TireOnRoad place_on_road(const Tire& tire, int stretch, const Marker& wheel, const std::string& name, double t) {
  const Vec3& c = wheel.point;
  const Vec3& v = wheel.velocity;
  const RoadHeight road = evaluate(*tire.road, stretch, c.x());
  const double n_z = 1.0 / std::sqrt(1.0 + road.slope * road.slope);
  const double n_z_rate = -road.slope * road.curvature * v.x() * n_z * n_z * n_z;
  const double rise = c.z() - road.h;
  const double distance_rate = (v.z() - road.slope * v.x()) * n_z + rise * n_z_rate;
  TireOnRoad at;
  at.normal = Vec3(-road.slope * n_z, 0.0, n_z);
  at.distance = rise * n_z;
  const Vec3 across = wheel.A_joint.col(1).cross(at.normal);
  if (!(across.norm() > 1e-6)) {
    throw SolverError(fmt::format(
        "cartesian: at t = {:.6g} s tire '{}' has no forward direction: its spin axis stands upright on the road", t,
        name));
  }
  at.forward = across.normalized();
  at.sideways = at.normal.cross(at.forward);
  const Vec3 slip = v - at.distance * wheel.angular_velocity.cross(at.normal);
  at.contact = {.x = c.x(),
                .delta = tire.radius - at.distance,
                .deltadot = -distance_rate,
                .V_x = v.dot(at.forward),
                .V_y = v.dot(at.sideways),
                .s_x = slip.dot(at.forward)};
  return at;
}

Vec3 on_axes(const TireOnRoad& at, const TireForces& forces) {
  return forces.N * at.normal + forces.F_x * at.forward + forces.F_y * at.sideways;
}

}  // namespace

void exert(const Tire& tire, const ForceInstant& at, AppliedForce& applied) {  // (S39)
  if (at.regimes == Regimes::own) applied.regime.stretch = stretch_at(*tire.road, applied.child().point.x());
  const TireOnRoad on_road = place_on_road(tire, applied.regime.stretch, applied.child(), at.name, at.t);
  if (at.regimes == Regimes::own) applied.regime = regime_at(tire, on_road.contact);
  const TireForces forces = evaluate(tire, applied.regime, on_road.contact);
  const Vec3 force = on_axes(on_road, forces);
  applied.on_child() = {force, -on_road.distance * on_road.normal.cross(force)};
}

int n_event_functions(const Tire& /*tire*/) { return kTireEvents; }

double* write_event_functions(const Tire& tire, const ForceInstant& at, const AppliedForce& applied, double* next) {
  const TireOnRoad on_road = place_on_road(tire, applied.regime.stretch, applied.child(), at.name, at.t);
  const auto values = event_functions_of(tire, applied.regime, on_road.contact);
  return std::copy(values.begin(), values.end(), next);
}

double departure_of(const Tire& tire, const ForceInstant& at, const AppliedForce& applied) {
  const int stretch = stretch_at(*tire.road, applied.child().point.x());
  const TireOnRoad own = place_on_road(tire, stretch, applied.child(), at.name, at.t);
  const TireForces of_own_regime = evaluate(tire, regime_at(tire, own.contact), own.contact);
  const Vec3 departure = applied.wrenches[index(Side::child)].force - on_axes(own, of_own_regime);
  return departure.norm() / (tire.stiffness * tire.radius);
}

}  // namespace concord::cartesian
