#include "compare/element_laws.h"

#include <cmath>

namespace concord::compare {

namespace {

using BothSides = std::array<Wrench, 2>;

constexpr int kParent = index(Side::parent);
constexpr int kChild = index(Side::child);

std::array<PlacedFrame, 2> place_ends(const std::array<Attachment, 2>& ends, const State& state) {
  return {place(ends[kParent], state.bodies[ends[kParent].body]), place(ends[kChild], state.bodies[ends[kChild].body])};
}

BothSides exert(const Load& load, const State& state) {
  const BodyState& body = state.bodies[load.at.body];
  Mat3 axes = Mat3::Identity();
  if (load.axes == LoadAxes::body) axes = rotation_of(body.p);
  if (load.axes == LoadAxes::follower) axes = place(load.at, body).A_joint;
  const double size = evaluate(load.law, state.t).f;
  BothSides wrenches;
  wrenches[kChild] = {size * (axes * load.force), size * (axes * load.torque)};
  return wrenches;
}

/// Law and actuator of an element, positive in tension.
double tension(const ForceLaw& law, double x, double xdot, double t) {
  return evaluate_resistance(law, x, xdot).force + evaluate_actuator(law, t);
}

BothSides exert(const LineSpring& spring, const State& state) {
  const auto frames = place_ends(spring.ends, state);
  const Vec3 line = frames[kChild].r_P - frames[kParent].r_P;
  const double length = line.norm();
  const Vec3 along = line / length;
  const double rate = along.dot(frames[kChild].v_P - frames[kParent].v_P);
  const Vec3 pull = tension(spring.law, length, rate, state.t) * along;
  return {Wrench{pull, Vec3::Zero()}, Wrench{-pull, Vec3::Zero()}};
}

/// With c = R e_x the child's x axis in the parent's frame, x = atan2(c_y, c_x); a small turn rho moves c by rho x c,
/// so that g = e_z - c_z (c_x e_x + c_y e_y) / (c_x^2 + c_y^2).
BothSides exert(const TurnSpring& spring, const State& state) {
  const auto frames = place_ends(spring.ends, state);
  const RelativeMotion relative = relative_motion(frames[kParent], frames[kChild]);
  const Vec3 c = relative.R.col(0);
  const Vec3 in_plane(c.x(), c.y(), 0.0);
  const Vec3 g = Vec3::UnitZ() - c.z() / in_plane.squaredNorm() * in_plane;
  const double angle = std::atan2(c.y(), c.x());
  const double rate = g.dot(relative.v_rel.tail<3>());
  const Vec3 torque = tension(spring.law, angle, rate, state.t) * (frames[kParent].A_joint * g);
  return {Wrench{Vec3::Zero(), torque}, Wrench{Vec3::Zero(), -torque}};
}

BothSides exert(const Bushing& bushing, const State& state) {
  const auto frames = place_ends(bushing.ends, state);
  const RelativeMotion relative = relative_motion(frames[kParent], frames[kChild]);
  const Vec3 theta = rotation_vector_of(relative.R);
  Vec6 offset;
  offset << relative.d, theta;
  Vec6 elastic = bushing.stiffness * offset - bushing.preload;
  elastic.tail<3>() = exponential_rate(theta).transpose().inverse() * Vec3(elastic.tail<3>());
  const Vec6 on_child = -elastic - bushing.damping * relative.v_rel;
  const Vec3 F = on_child.head<3>();
  const Vec3 T = on_child.tail<3>();
  const Mat3& A = frames[kParent].A_joint;
  return {Wrench{-A * F, -A * (T + relative.d.cross(F))}, Wrench{A * F, A * T}};
}

/// The contact is the foot of the perpendicular from the wheel's centre to the road's tangent plane below it. With the
/// height z of the centre over the profile, D = z cos(b), tan(b) = h', and bdot = h'' cos(b)^2 xdot.
BothSides exert(const Tire& tire, const State& state) {
  const PlacedFrame wheel = place(tire.wheel, state.bodies[tire.wheel.body]);
  TireContact contact;
  contact.x = wheel.r_P.x();
  const RoadHeight road = evaluate(*tire.road, stretch_at(*tire.road, contact.x), contact.x);
  const double incline = std::atan(road.slope);
  const Vec3 normal(-std::sin(incline), 0.0, std::cos(incline));
  const double above = wheel.r_P.z() - road.h;
  const double distance = above * std::cos(incline);
  const double incline_rate = road.curvature * std::cos(incline) * std::cos(incline) * wheel.v_P.x();
  const double distance_rate =
      (wheel.v_P.z() - road.slope * wheel.v_P.x()) * std::cos(incline) - above * std::sin(incline) * incline_rate;
  contact.delta = tire.radius - distance;
  contact.deltadot = -distance_rate;

  const Vec3 forward = wheel.A_joint.col(1).cross(normal).normalized();
  const Vec3 sideways = normal.cross(forward);
  const Vec3 lever = -distance * normal;
  contact.V_x = wheel.v_P.dot(forward);
  contact.V_y = wheel.v_P.dot(sideways);
  contact.s_x = (wheel.v_P + wheel.omega_joint.cross(lever)).dot(forward);
  const TireForces forces = evaluate(tire, regime_at(tire, contact), contact);
  const Vec3 force = forces.N * normal + forces.F_x * forward + forces.F_y * sideways;
  BothSides wrenches;
  wrenches[kChild] = {force, lever.cross(force)};
  return wrenches;
}

}  // namespace

std::array<Wrench, 2> lawful_wrenches(const ForceElement& element, const State& state) {
  return std::visit([&state](const auto& what) { return exert(what, state); }, element.what);
}

}  // namespace concord::compare
