#pragma once

#include <array>

#include "common/elements/force_element.h"
#include "common/results.h"
#include "relative/bodies/joint_point.h"

/// The wrench of each kind of force element.
namespace concord::relative {

/// A force law whose stops keep their regime while an integrator makes a step, and what it was last asked for.
struct LawInRegime {
  const ForceLaw* law = nullptr;
  LawRegime regime;
  double x = 0.0;
  double xdot = 0.0;

  /// Resistance at x with rate xdot; takes the regime that the stops are in by themselves unless it `keeps` its own.
  double resist(double at_x, double at_xdot, bool keeps);
  [[nodiscard]] std::array<double, kLawEvents> event_functions() const {
    return event_functions_of(*law, regime, x, xdot);
  }
  [[nodiscard]] double departure() const { return departure_of(*law, regime, x, xdot); }
};

/// The angle of a turn spring through whole turns. Its ends tell it but for these: it is the one nearest to what the
/// rates make of the angle that was known last, x + (xdot + xdot(t)) (t - t_known) / 2 (R78).
struct CountedAngle {
  struct Instant {
    double t = 0.0;
    double x = kUnwound;
    double xdot = 0.0;
  };
  Instant known;
  Instant last;  // what was counted last

  /// Counts the turns of an angle [rad] with rate xdot at time t.
  double count(double t, double angle, double xdot);
  /// How far the last angle is from where the rates led [rad]: beyond a quarter turn it may be on another turn.
  [[nodiscard]] double stray() const { return last.x - predicted(last.t, last.xdot); }
  /// Goes on from the last angle.
  void follow() { known = last; }

 private:
  [[nodiscard]] double predicted(double t, double xdot) const {
    return known.x + 0.5 * (known.xdot + xdot) * (t - known.t);
  }
};

/// How the ends of a turn spring are turned against each other.
struct EndTurn {
  double angle;     // from the parent's x axis to the child's about the parent's z, in [-pi, pi] [rad]
  double xdot;      // its rate
  Vec3 g;           // its gradient over a turn of the child's end, in the parent's axes
  double in_plane;  // what of the child's x axis is seen along the parent's z; zero: there is no angle
};
EndTurn turn_between(const JointPoint& parent, const JointPoint& child);

/// What an element between two ends exerts on the child at P_i [F; T], global axes. The parent gets the opposite, moved
/// to P_j: the line of a line spring passes through both ends, all else is stated with that shift or is a couple.
/// `name` is for the SolverError of a pose in which the element is not defined.

/// A load on the body of `at`, whose frame is turned by `body_A`; there is no parent.
Vec6 wrench_of(const Load& load, double t, const Mat3& body_A, const JointPoint& at);

/// -f n along the line n from parent to child, f = tension. Throws SolverError if the ends are closer than 1e-9 of
/// `length`, the machine's.
Vec6 wrench_of(const LineSpring& spring, double t, const JointPoint& parent, const JointPoint& child, double length,
               const std::string& name, LawInRegime& law_in_regime, bool keeps_regime);

/// By how much the force of a line spring jumps where its ends pass each other with this speed [N]: x' is -speed before
/// and speed behind, the direction turns over, so that f(0, -speed) + f(0, speed) is left.
double jump_where_ends_pass(const LineSpring& spring, double t, double speed);

/// A torque on the child alone, -f dx/drho, x measured in the parent's end frame and its turns counted. Throws
/// SolverError if the child's x axis points along the parent's z.
Vec6 wrench_of(const TurnSpring& spring, double t, const JointPoint& parent, const JointPoint& child,
               const std::string& name, CountedAngle& angle, LawInRegime& law_in_regime, bool keeps_regime);

/// -L^T (K [d; theta] - preload) - D v_rel. Throws SolverError if |theta| is beyond 175 deg, where the bushing
/// resists it.
Vec6 wrench_of(const Bushing& bushing, const JointPoint& parent, const JointPoint& child, const std::string& name);

}  // namespace concord::relative
