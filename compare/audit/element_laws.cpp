#include "compare/audit/element_laws.h"

#include <cmath>
#include <numbers>

#include "common/overloaded.h"

namespace concord::compare {

namespace {

constexpr int kParent = index(Side::parent);
constexpr int kChild = index(Side::child);
constexpr double kWholeTurn = 2.0 * std::numbers::pi;

std::array<PlacedFrame, 2> place_ends(const std::array<Attachment, 2>& ends, const State& state) {
  return {place(ends[kParent], state.bodies[ends[kParent].body]), place(ends[kChild], state.bodies[ends[kChild].body])};
}

struct SlipForces {
  double forward = 0.0;
  double sideways = 0.0;
};

/// Forces along the road of a tire that is pressed by N: against the slip s_x and the slip angle V_y / V, each over
/// V = sqrt(V_x^2 + speed_scale^2), both shortened by one factor where together they exceed friction N.
SlipForces slip_forces(const Tire& tire, double N, double V_x, double V_y, double s_x) {
  const double V = std::sqrt(V_x * V_x + tire.speed_scale * tire.speed_scale);
  const Eigen::Vector2d grip(-tire.slip_stiffness * s_x / V, -tire.cornering_stiffness * V_y / V);
  const double limit = tire.friction * N;
  const double shortened = grip.norm() > limit ? limit / grip.norm() : 1.0;
  return {shortened * grip.x(), shortened * grip.y()};
}

}  // namespace

LineMotion motion_of(const LineSpring& spring, const State& state) {
  const auto frames = place_ends(spring.ends, state);
  const Vec3 line = frames[kChild].r_P - frames[kParent].r_P;
  const double distance = line.norm();
  const Vec3 parting = frames[kChild].v_P - frames[kParent].v_P;
  const Vec3 along = distance > 0.0 ? Vec3(line / distance) : parting.stableNormalized();
  return {distance, along.dot(parting), along};
}

/// With c = R e_x the child's x axis in the parent's frame, x = atan2(c_y, c_x); a small turn rho moves c by rho x c,
/// so that g = e_z - c_z (c_x e_x + c_y e_y) / (c_x^2 + c_y^2).
TurnMotion motion_of(const TurnSpring& spring, const State& state, double known_angle) {
  const auto frames = place_ends(spring.ends, state);
  const RelativeMotion relative = relative_motion(frames[kParent], frames[kChild]);
  const Vec3 c = relative.R.col(0);
  const Vec3 in_plane(c.x(), c.y(), 0.0);
  const Vec3 g = Vec3::UnitZ() - c.z() / in_plane.squaredNorm() * in_plane;
  const double read = std::atan2(c.y(), c.x());
  const double turns = std::round((known_angle - read) / kWholeTurn);
  return {read + turns * kWholeTurn, g.dot(relative.v_rel.tail<3>()), frames[kParent].A_joint * g};
}

double OwnLaws::tension(double x, double xdot, double t) const {
  return force->resistance(x, xdot) + force->actuator(t);
}

// One clause for each kind of force element.
namespace {

using BothSides = std::array<Wrench, 2>;

/// Of which element of a model, with which laws.
struct Asked {
  const OwnLaws& laws;
  std::size_t place;
};

BothSides exerted(const Load& load, const Asked& by, const State& state) {
  const BodyState& body = state.bodies[load.at.body];
  Mat3 axes = Mat3::Identity();
  if (load.axes == LoadAxes::body) axes = rotation_of(body.p);
  if (load.axes == LoadAxes::follower) axes = place(load.at, body).A_joint;
  const double size = by.laws.time->at(state.t).value;
  BothSides wrenches;
  wrenches[kChild] = {size * (axes * load.force), size * (axes * load.torque)};
  return wrenches;
}

BothSides exerted(const LineSpring& spring, const Asked& by, const State& state) {
  const LineMotion motion = motion_of(spring, state);
  const Vec3 pull = by.laws.tension(motion.distance, motion.rate, state.t) * motion.along;
  return {Wrench{pull, Vec3::Zero()}, Wrench{-pull, Vec3::Zero()}};
}

BothSides exerted(const TurnSpring& spring, const Asked& by, const State& state) {
  const TurnMotion motion = motion_of(spring, state, state.known_angle(by.place));
  const Vec3 torque = by.laws.tension(motion.angle, motion.rate, state.t) * motion.gradient;
  return {Wrench{Vec3::Zero(), torque}, Wrench{Vec3::Zero(), -torque}};
}

BothSides exerted(const Bushing& bushing, const Asked& /*by*/, const State& state) {
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
/// height z of the centre over the profile, the distance is z cos(b), tan(b) = h', and bdot = h'' cos(b)^2 xdot. The
/// tire pushes along the normal, and never pulls.
BothSides exerted(const Tire& tire, const Asked& by, const State& state) {
  const PlacedFrame wheel = place(tire.wheel, state.bodies[tire.wheel.body]);
  const Moving road = by.laws.road->at(wheel.r_P.x());  // height, slope, curvature
  const double incline = std::atan(road.rate);
  const Vec3 normal(-std::sin(incline), 0.0, std::cos(incline));
  const double above = wheel.r_P.z() - road.value;
  const double distance = above * std::cos(incline);
  const double incline_rate = road.rate_of_rate * std::cos(incline) * std::cos(incline) * wheel.v_P.x();
  const double distance_rate =
      (wheel.v_P.z() - road.rate * wheel.v_P.x()) * std::cos(incline) - above * std::sin(incline) * incline_rate;
  const double deflection = tire.radius - distance;
  const double N = tire.stiffness * deflection - tire.damping * distance_rate;
  BothSides wrenches;
  if (deflection <= 0.0 || N <= 0.0) return wrenches;

  const Vec3 forward = wheel.A_joint.col(1).cross(normal).normalized();
  const Vec3 sideways = normal.cross(forward);
  const Vec3 lever = -distance * normal;
  const Vec3 slip = wheel.v_P + wheel.omega_joint.cross(lever);
  const SlipForces grip = slip_forces(tire, N, wheel.v_P.dot(forward), wheel.v_P.dot(sideways), slip.dot(forward));
  const Vec3 force = N * normal + grip.forward * forward + grip.sideways * sideways;
  wrenches[kChild] = {force, lever.cross(force)};
  return wrenches;
}

}  // namespace

ElementLaw::ElementLaw(const ForceElement& stated, std::size_t place) : stated_(&stated), place_(place) {
  each_quantity(
      stated,
      Overloaded{elements::IgnoreQuantity{},
                 [this](const elements::FactorOverTime<const TimeFunction>& law) { laws_.time.emplace(law.value); },
                 [this](const elements::LawOverCoordinate<const ForceLaw>& law) { laws_.force.emplace(law.value); },
                 [this](const elements::RoadBelow<const std::shared_ptr<const Road>>& road) {
                   laws_.road.emplace(*road.value);
                 }});
}

std::array<Wrench, 2> ElementLaw::wrenches(const State& state) const {
  return std::visit([&](const auto& what) { return exerted(what, Asked{laws_, place_}, state); }, stated_->what);
}

std::array<Wrench, 2> wrenches_by_laws(const ForceElement& element, const State& state, std::size_t place) {
  return ElementLaw(element, place).wrenches(state);
}

}  // namespace concord::compare
