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

double terms_of(const ForceLaw& law, double x) {
  return std::abs(law.stiffness) * (std::abs(x) + std::abs(law.free)) + std::abs(law.preload);
}

double distance_of(const std::array<Attachment, 2>& ends, const State& state) {
  const auto at = [&](const Attachment& end) { return place(end, state.bodies[end.body]).r_P; };
  return (at(ends[1]) - at(ends[0])).norm();
}

SpringTerms terms_of(const Bushing& bushing, const State& state) {
  Vec6 motion;
  motion << Vec3::Constant(distance_of(bushing.ends, state)), Vec3::Constant(kUnitTurn);
  const Vec6 terms = bushing.stiffness.cwiseAbs() * motion + bushing.preload.cwiseAbs();
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
                                 return SpringTerms{terms_of(spring.law, distance_of(spring.ends, state)), 0.0};
                               },
                               [&](const TurnSpring& spring) {
                                 return SpringTerms{0.0, terms_of(spring.law, kUnitTurn)};
                               },
                               [&](const Bushing& bushing) { return terms_of(bushing, state); }},
                    element.what);
}

SpringTerms spring_terms(const Joint& joint, const VecX& q) {
  SpringTerms terms;
  if (joint.springs.empty()) return terms;
  const std::vector<bool> turning = turning_speeds(*joint.type);
  for (const JointSpring& spring : joint.springs) {
    const int k = first_q(*joint.type, spring.word) + spring.component;
    const int speed = first_u(*joint.type, spring.word) + spring.component;
    double& size = turning[static_cast<std::size_t>(speed)] ? terms.torque : terms.force;
    size = std::max(size, terms_of(spring.law, k < q.size() ? q(k) : 0.0));
  }
  return terms;
}

}  // namespace concord::compare
