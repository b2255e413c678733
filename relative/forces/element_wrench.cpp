#include "relative/forces/element_wrench.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "relative/bodies/exponential_map.h"
#include "relative/bodies/turns.h"
#include "relative/bodies/velocity_transformation.h"

namespace concord::relative {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kLargestAngle = 175.0 * kDegree;
constexpr double kNoLength = 1e-9;     // of the machine's length: the direction is round-off to seven digits
constexpr double kOnePoint = 1e-14;    // the same: there is no direction
constexpr double kNoDirection = 1e-6;  // of a unit axis seen along another

Vec6 rotated(const Mat3& A, const Vec6& w) {
  Vec6 result;
  result << A * w.head<3>(), A * w.tail<3>();
  return result;
}

[[noreturn]] void throw_turned_too_far(const std::string& name, double angle) {
  throw SolverError(
      fmt::format("relative: force element '{}': its ends are turned by {:.4g} deg against each other, "
                  "allowed are 175 deg: turn the frames of its ends",
                  name, angle / kDegree));
}

/// Of a line that is next to nothing: its own as long as it has one; in one point, that in which the ends part, the
/// limit of a force without a jump from either side; zero at rest there. Throws SolverError if the force jumps.
Vec3 direction_of_short(const Vec3& line, double length, const JointPoint& parent, const JointPoint& child,
                        const LineSpring& spring, double t, const std::string& name) {
  const double x = line.norm();
  const Vec3 parting = child.v - parent.v;
  if (jump_where_ends_pass(spring, t, parting.norm()) != 0.0) {
    throw SolverError(
        fmt::format("relative: force element '{}': its ends are {:.1e} m apart, so that its force has no "
                    "direction: move an end",
                    name, x));
  }
  return x > kOnePoint * length ? Vec3(line / x) : parting.stableNormalized();
}

}  // namespace

double LawInRegime::resist(double at_x, double at_xdot, bool keeps) {
  x = at_x;
  xdot = at_xdot;
  if (!keeps) regime = regime_at(*law, x, xdot);
  return evaluate_resistance(*law, regime, x, xdot).force;
}

Vec6 wrench_of(const Load& load, double t, const Mat3& body_A, const JointPoint& at) {
  Vec6 w;
  w << load.force, load.torque;
  w *= evaluate(load.law, t).f;
  switch (load.axes) {
    case LoadAxes::body:
      return rotated(body_A, w);
    case LoadAxes::follower:
      return rotated(at.A, w);
    default:
      return w;
  }
}

Vec6 wrench_of(const LineSpring& spring, double t, const JointPoint& parent, const JointPoint& child, double length,
               const std::string& name, LawInRegime& law_in_regime, bool keeps_regime) {
  const Vec3 line = child.r - parent.r;
  const double x = line.norm();
  const Vec3 n =
      x > kNoLength * length ? Vec3(line / x) : direction_of_short(line, length, parent, child, spring, t, name);
  const double f = law_in_regime.resist(x, n.dot(child.v - parent.v), keeps_regime) + evaluate_actuator(spring.law, t);
  Vec6 w;
  w << -f * n, Vec3::Zero();
  return w;
}

double jump_where_ends_pass(const LineSpring& spring, double t, double speed) {
  return evaluate_resistance(spring.law, 0.0, -speed).force + evaluate_resistance(spring.law, 0.0, speed).force +
         2.0 * evaluate_actuator(spring.law, t);
}

double CountedAngle::count(double t, double angle, double xdot) {
  const double turns = std::round((predicted(t, xdot) - angle) / static_cast<double>(kWholeTurn));
  last = {t, add_turns(angle, turns), xdot};
  return last.x;
}

/// The child's x axis c in the parent's frame moves by rho x c, so that x = atan2(c_y, c_x) changes by
/// rho_z - c_z (c_x rho_x + c_y rho_y) / (c_x^2 + c_y^2).
EndTurn turn_between(const JointPoint& parent, const JointPoint& child) {
  const Vec3 c = parent.A.transpose() * child.A.col(0);
  const double in_plane = std::hypot(c.x(), c.y());
  const double lean = c.z() / (in_plane * in_plane);
  const Vec3 g(-lean * c.x(), -lean * c.y(), 1.0);
  return {std::atan2(c.y(), c.x()), g.dot(parent.A.transpose() * (child.omega - parent.omega)), g, in_plane};
}

Vec6 wrench_of(const TurnSpring& spring, double t, const JointPoint& parent, const JointPoint& child,
               const std::string& name, CountedAngle& angle, LawInRegime& law_in_regime, bool keeps_regime) {
  const EndTurn turn = turn_between(parent, child);
  if (!(turn.in_plane > kNoDirection)) {
    throw SolverError(
        fmt::format("relative: force element '{}': the child's x axis points along the parent's z, so that it has no "
                    "angle: turn the frames of its ends",
                    name));
  }
  const double x = angle.count(t, turn.angle, turn.xdot);
  const double f = law_in_regime.resist(x, turn.xdot, keeps_regime) + evaluate_actuator(spring.law, t);
  Vec6 w;
  w << Vec3::Zero(), parent.A * (-f * turn.g);
  return w;
}

Vec6 wrench_of(const Bushing& bushing, const JointPoint& parent, const JointPoint& child, const std::string& name) {
  const bool holds_angles = !bushing.preload.tail<3>().isZero(0.0) || !bushing.stiffness.rightCols<3>().isZero(0.0);
  Vec3 theta = Vec3::Zero();
  if (holds_angles) {
    theta = rotation_vector(parent.A.transpose() * child.A);
    if (theta.norm() > kLargestAngle) throw_turned_too_far(name, theta.norm());
  }
  Vec6 displacement;
  displacement << parent.A.transpose() * (child.r - parent.r), theta;
  Vec6 w = bushing.preload - bushing.stiffness * displacement;
  w.tail<3>() = (exponential_map(theta).J.transpose().inverse() * w.tail<3>()).eval();
  w -= bushing.damping * relative_velocity(parent, child);
  return rotated(parent.A, w);
}

}  // namespace concord::relative
