#include "cartesian/forces/spring_forces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cartesian/forces/element_forces.h"
#include "common/error.h"

namespace concord::cartesian {

namespace {

/// What a turn spring takes for its angle.
const joints::Read kSpringAngle = joints::TurnOfChildAxis{.about = Axis::z, .of_child_axis = Axis::x};

/// Resistance of a spring's law, in the regime that the applied force takes or keeps.
double resistance(const ForceLaw& law, const ForceInstant& at, double x, double rate, AppliedForce& applied) {
  LawRegime& regime = applied.stop_regimes.front();
  if (at.regimes == Regimes::own) regime = regime_at(law, x, rate);
  return evaluate_resistance(law, regime, x, rate).force;
}

int n_event_functions(const ForceLaw& law) { return has_regimes(law) ? kLawEvents : 0; }

/// What a law is asked for: x and its rate.
struct Asked {
  double x;
  double rate;
};

Asked stretch_of(const ForceInstant& at, const AppliedForce& applied) {
  const Vec3 line = applied.child().point - applied.parent().point;
  const double length = line.norm();
  const Vec3 closing = applied.child().velocity - applied.parent().velocity;
  return {length, length > at.shortest_line ? line.dot(closing) / length : 0.0};
}

Asked turn_of(const AppliedForce& applied, const ConstraintRow& angle) {
  return {value_near(true, angle, applied.known_angle), rate_of(angle, applied.motion)};
}

Asked turn_of(const AppliedForce& applied) { return turn_of(applied, evaluate_read(kSpringAngle, 0, applied.motion)); }

double* write_event_functions(const ForceLaw& law, const AppliedForce& applied, const Asked& at, double* next) {
  const auto values = event_functions_of(law, applied.stop_regimes.front(), at.x, at.rate);
  return std::copy(values.begin(), values.end(), next);
}

double departure_of(const ForceLaw& law, const AppliedForce& applied, const Asked& at) {
  return concord::departure_of(law, applied.stop_regimes.front(), at.x, at.rate);
}

}  // namespace

void exert(const LineSpring& spring, const ForceInstant& at, AppliedForce& applied) {  // (S33)
  const Vec3 line = applied.child().point - applied.parent().point;
  const Vec3 velocity = applied.child().velocity - applied.parent().velocity;
  const double length = line.norm();
  Vec3 along = line / length;
  if (!(length > at.shortest_line)) {
    constexpr double kRoundOff = 1e-5;  // of the shortest line: less of it has no direction at all
    if (line_of(spring, at.name, applied, at.t).is_reversed_with_a_jump) {
      throw SolverError(
          fmt::format("cartesian: at t = {:.6g} s the ends of line spring '{}' meet: its force has no direction there",
                      at.t, at.name));
    }
    // In one point, they part along their velocity; at rest there, nothing acts.
    if (!(length > kRoundOff * at.shortest_line)) along = velocity.stableNormalized();
  }
  const double rate = along.dot(velocity);
  const double tension = resistance(spring.law, at, length, rate, applied) + evaluate_actuator(spring.law, at.t);
  applied.on_child() = {-tension * along, Vec3::Zero()};
  applied.on_parent() = {tension * along, Vec3::Zero()};
}

void exert(const TurnSpring& spring, const ForceInstant& at, AppliedForce& applied) {  // (S34)
  if (!(applied.motion.R.col(0).head<2>().norm() > 1e-6)) {
    throw SolverError(
        fmt::format("cartesian: at t = {:.6g} s turn spring '{}' has no angle: the child's x axis points along the "
                    "parent's z: turn the frames of its ends",
                    at.t, at.name));
  }
  const ConstraintRow angle = evaluate_read(kSpringAngle, 0, applied.motion);
  const auto [x, rate] = turn_of(applied, angle);
  const double torque = resistance(spring.law, at, x, rate, applied) + evaluate_actuator(spring.law, at.t);
  const Vec3 couple = applied.parent().A_joint * (-torque * angle.over_rho);
  applied.on_child() = {Vec3::Zero(), couple};
  applied.on_parent() = {Vec3::Zero(), -couple};
}

double angle_of_turn_spring(const AppliedForce& applied) { return turn_of(applied).x; }

int n_event_functions(const LineSpring& spring) { return n_event_functions(spring.law); }
int n_event_functions(const TurnSpring& spring) { return n_event_functions(spring.law); }

double* write_event_functions(const LineSpring& spring, const ForceInstant& at, const AppliedForce& applied,
                              double* next) {
  return write_event_functions(spring.law, applied, stretch_of(at, applied), next);
}

double* write_event_functions(const TurnSpring& spring, const ForceInstant& /*at*/, const AppliedForce& applied,
                              double* next) {
  return write_event_functions(spring.law, applied, turn_of(applied), next);
}

double departure_of(const LineSpring& spring, const ForceInstant& at, const AppliedForce& applied) {
  return departure_of(spring.law, applied, stretch_of(at, applied));
}

double departure_of(const TurnSpring& spring, const ForceInstant& /*at*/, const AppliedForce& applied) {
  return departure_of(spring.law, applied, turn_of(applied));
}

SpringLine line_of(const LineSpring& spring, const std::string& name, const AppliedForce& applied, double t) {
  const Vec3 rate = applied.child().velocity - applied.parent().velocity;
  const double speed = rate.norm();
  const double actuator = evaluate_actuator(spring.law, t);
  // The tension of ends that come together, and of ends that go apart: continuous if it only changes its sign.
  const double before = evaluate_resistance(spring.law, 0.0, -speed).force + actuator;
  const double behind = evaluate_resistance(spring.law, 0.0, speed).force + actuator;
  return {&name, applied.child().point - applied.parent().point, rate, before != -behind};
}

}  // namespace concord::cartesian
