#include "compare/verdict/spring_terms.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/overloaded.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"

namespace concord::compare {

namespace {

constexpr double kUnitTurn = 1.0;  // rad: angles are read from rotations, whose numbers are of size 1

double terms_of(const ForceLaw& law, double x, double xdot) {
  return std::abs(law.stiffness) * (std::abs(x) + std::abs(law.free)) + std::abs(law.preload) +
         std::abs(law.damping * xdot);
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

SpringTerms terms_of(const Bushing& bushing, const State& state) {
  const EndMotion ends(bushing.ends, state);
  Vec6 motion;
  motion << Vec3::Constant(ends.distance), Vec3::Constant(kUnitTurn);
  Vec6 rates;
  rates << Vec3::Constant(ends.speed), Vec3::Constant(ends.turning);
  const Vec6 terms =
      bushing.stiffness.cwiseAbs() * motion + bushing.damping.cwiseAbs() * rates + bushing.preload.cwiseAbs();
  return {terms.head<3>().maxCoeff(), terms.tail<3>().maxCoeff()};
}

}  // namespace

SpringTerms spring_terms(const ForceElement& element, const State& state) {
  return std::visit(Overloaded{[](const Load&) { return SpringTerms{}; },
                               [](const Tire& tire) {
                                 // The deflection is the radius less the height of the wheel's centre.
                                 const double force = tire.stiffness * tire.radius;
                                 return SpringTerms{force, force * tire.radius};
                               },
                               [&](const LineSpring& spring) {
                                 const EndMotion ends(spring.ends, state);
                                 return SpringTerms{terms_of(spring.law, ends.distance, ends.speed), 0.0};
                               },
                               [&](const TurnSpring& spring) {
                                 const EndMotion ends(spring.ends, state);
                                 return SpringTerms{0.0, terms_of(spring.law, kUnitTurn, ends.turning)};
                               },
                               [&](const Bushing& bushing) { return terms_of(bushing, state); }},
                    element.what);
}

SpringTerms spring_terms(const Joint& joint, const VecX& q, const VecX& u) {
  SpringTerms terms;
  if (joint.springs.empty()) return terms;
  const std::vector<bool> turning = turning_speeds(*joint.type);
  for (const JointSpring& spring : joint.springs) {
    const int k = first_q(*joint.type, spring.word) + spring.component;
    const int speed = first_u(*joint.type, spring.word) + spring.component;
    double& size = turning[static_cast<std::size_t>(speed)] ? terms.torque : terms.force;
    size = std::max(size, terms_of(spring.law, k < q.size() ? q(k) : 0.0, speed < u.size() ? u(speed) : 0.0));
  }
  return terms;
}

}  // namespace concord::compare
