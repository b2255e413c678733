#include "cartesian/forces/joint_springs.h"

#include <algorithm>

namespace concord::cartesian {

namespace {

/// The coordinate that a spring acts on, turns counted, and its rate.
struct SprungCoordinate {
  double x;
  double rate;
};

SprungCoordinate read_sprung(const Joint& stated, std::size_t k, const RelativeMotion& motion,
                             const AppliedForce& applied) {
  const JointSpring& spring = stated.springs[k];
  const ConstraintRow row = evaluate_read(*read_of(*stated.type, spring.word), spring.component, motion);
  const double known = applied.known_q(first_q(*stated.type, spring.word) + spring.component);
  return {value_near(applied.spring_turns[k], row, known), rate_of(row, motion)};
}

}  // namespace

/// tau = actuator - resistance for each sprung coordinate; the coordinate wrench acts like the joint's own (C38).
void exert_springs(const Joint& stated, const JointEquations& joint, double t, Regimes regimes, AppliedForce& applied) {
  applied.tau.setZero();
  for (std::size_t k = 0; k < stated.springs.size(); ++k) {
    const JointSpring& spring = stated.springs[k];
    const auto [x, rate] = read_sprung(stated, k, joint.motion, applied);
    if (regimes == Regimes::own) applied.stop_regimes[k] = regime_at(spring.law, x, rate);
    const double resistance = evaluate_resistance(spring.law, applied.stop_regimes[k], x, rate).force;
    const int u = first_u(*stated.type, spring.word) + spring.component;
    applied.tau(u) += evaluate_actuator(spring.law, t) - resistance;
  }
  const Vec6 in_C = coordinate_wrench(*stated.type, joint.motion, applied.tau);
  const Mat3& A_joint = joint.marker(Side::parent).A_joint;
  applied.on_child() = {A_joint * in_C.head<3>(), A_joint * in_C.tail<3>()};
  applied.on_parent() = opposite(applied.on_child(), joint.gap);
}

void add_spring_shares(const Joint& stated, const JointEquations& joint, double t, const AppliedForce& applied,
                       std::array<VecX, kActors.size()>& shares) {
  for (std::size_t k = 0; k < stated.springs.size(); ++k) {
    const JointSpring& spring = stated.springs[k];
    const auto [x, rate] = read_sprung(stated, k, joint.motion, applied);
    const double resistance = evaluate_resistance(spring.law, applied.stop_regimes[k], x, rate).force;
    const double at_rest = evaluate_resistance(spring.law, x, 0.0).force;
    const int u = first_u(*stated.type, spring.word) + spring.component;
    shares[index(Actor::motor)](u) += evaluate_actuator(spring.law, t);
    shares[index(Actor::spring)](u) -= at_rest;
    shares[index(Actor::damper)](u) -= resistance - at_rest;
  }
}

int n_event_functions(const Joint& stated) {
  const bool has_any = std::any_of(stated.springs.begin(), stated.springs.end(),
                                   [](const JointSpring& spring) { return has_regimes(spring.law); });
  return has_any ? kLawEvents * static_cast<int>(stated.springs.size()) : 0;
}

double* write_event_functions(const Joint& stated, const RelativeMotion& motion, const AppliedForce& applied,
                              double* next) {
  for (std::size_t k = 0; k < stated.springs.size(); ++k) {
    const auto [x, rate] = read_sprung(stated, k, motion, applied);
    const auto values = event_functions_of(stated.springs[k].law, applied.stop_regimes[k], x, rate);
    next = std::copy(values.begin(), values.end(), next);
  }
  return next;
}

double departure_of(const Joint& stated, const RelativeMotion& motion, const AppliedForce& applied) {
  double largest = 0.0;
  for (std::size_t k = 0; k < stated.springs.size(); ++k) {
    const auto [x, rate] = read_sprung(stated, k, motion, applied);
    largest = std::max(largest, departure_of(stated.springs[k].law, applied.stop_regimes[k], x, rate));
  }
  return largest;
}

}  // namespace concord::cartesian
