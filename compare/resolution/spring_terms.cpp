#include "compare/resolution/spring_terms.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/overloaded.h"
#include "compare/audit/element_laws.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/law_of_force.h"
#include "compare/audit/places.h"

namespace concord::compare {

namespace {

constexpr double kUnitTurn = 1.0;  // rad: angles are read from rotations, whose numbers are of size 1

/// Where a law is read: x, the size of the numbers that it is read from, its rate, and the time.
struct Reading {
  double x = 0.0;
  double size = 0.0;
  double xdot = 0.0;
  double t = 0.0;
};

/// Of a stop that is pressed by p. What its spring and its damper add up counts even where they cancel.
double terms_of(const SmoothStop& stop, double p, const Reading& reading) {
  if (p <= 0.0) return 0.0;
  return share_of(p / stop.width) *
         (std::abs(stop.stiffness) * (reading.size + std::abs(stop.at)) + std::abs(stop.damping * reading.xdot));
}

/// Of a table: its force, and what the size of its argument makes of it.
double terms_of(const ForceTable& table, double argument, double size) {
  return std::abs(table.evaluate(argument)) + std::abs(table.slope(argument)) * size;
}

double terms_of(const ForceLaw& law, const Reading& reading) {
  const auto& [x, size, xdot, t] = reading;
  const double stretched = size + std::abs(law.free);
  double terms = std::abs(law.stiffness) * stretched + std::abs(law.preload) + std::abs(law.damping * xdot) +
                 std::abs(evaluate_actuator(law, t));
  if (law.spring_table) terms += terms_of(*law.spring_table, x - law.free, stretched);
  if (law.damper_table) terms += terms_of(*law.damper_table, xdot, std::abs(xdot));
  if (law.upper) terms += terms_of(*law.upper, x - law.upper->at, reading);
  if (law.lower) terms += terms_of(*law.lower, law.lower->at - x, reading);
  return terms;
}

/// How far apart the ends are, and how fast they move and turn against each other.
struct EndMotion {
  double distance = 0.0;
  double speed = 0.0;
  double turning = 0.0;

  EndMotion(const std::array<Attachment, 2>& ends, const State& state) {
    const PlacedFrame one = place(ends[0], state.bodies[ends[0].body]);
    const PlacedFrame other = place(ends[1], state.bodies[ends[1].body]);
    distance = (other.r_P - one.r_P).norm();
    speed = (other.v_P - one.v_P).norm();
    turning = (other.omega_joint - one.omega_joint).norm();
  }
};

/// Of an element that makes wrenches of the motion of its ends.
SpringTerms terms_by_quantities(const ForceElement& element, const State& state) {
  if (ends_of(element).size() < 2) return {};
  const EndMotion ends({ends_of(element).front(), ends_of(element).back()}, state);
  Vec6 motion;
  motion << Vec3::Constant(ends.distance), Vec3::Constant(kUnitTurn);
  Vec6 rates;
  rates << Vec3::Constant(ends.speed), Vec3::Constant(ends.turning);
  Vec6 terms = Vec6::Zero();
  each_quantity(element,
                Overloaded{elements::IgnoreQuantity{},
                           [&](const elements::WrenchMatrix<const Mat6>& matrix) {
                             terms += matrix.value.cwiseAbs() * (matrix.per_rate ? rates : motion);
                           },
                           [&](const elements::Wrench6<const Vec6>& wrench) { terms += wrench.value.cwiseAbs(); }});
  return {terms.head<3>().maxCoeff(), terms.tail<3>().maxCoeff()};
}

}  // namespace

SpringTerms spring_terms(const ForceElement& element, const State& state, double known_angle) {
  return std::visit(
      Overloaded{[](const Tire& tire) {
                   // The deflection is the radius less the height of the wheel's centre.
                   const double force = tire.stiffness * tire.radius;
                   return SpringTerms{force, force * tire.radius};
                 },
                 [&](const LineSpring& spring) {
                   const EndMotion ends(spring.ends, state);
                   return SpringTerms{terms_of(spring.law, {ends.distance, ends.distance, ends.speed, state.t}), 0.0};
                 },
                 [&](const TurnSpring& spring) {
                   const EndMotion ends(spring.ends, state);
                   const double angle = motion_of(spring, state, known_angle).angle;
                   const double size = std::max(kUnitTurn, std::abs(angle));
                   return SpringTerms{0.0, terms_of(spring.law, {angle, size, ends.turning, state.t})};
                 },
                 [&](const auto& /*other*/) { return terms_by_quantities(element, state); }},
      element.what);
}

SpringTerms spring_terms(const Joint& joint, const VecX& q, const VecX& u, double t) {
  SpringTerms terms;
  if (joint.springs.empty()) return terms;
  const std::vector<bool> turning = turning_speeds(*joint.type);
  for (const JointSpring& spring : joint.springs) {
    const int k = first_q(*joint.type, spring.word) + spring.component;
    const int speed = first_u(*joint.type, spring.word) + spring.component;
    double& size = turning[static_cast<std::size_t>(speed)] ? terms.torque : terms.force;
    const double x = k < q.size() ? q(k) : 0.0;
    size = std::max(size, terms_of(spring.law, {x, std::abs(x), speed < u.size() ? u(speed) : 0.0, t}));
  }
  return terms;
}

}  // namespace concord::compare
