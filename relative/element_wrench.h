#pragma once

#include <array>

#include "common/laws/force_elements.h"
#include "relative/joint_point.h"

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

/// A torque on the child alone, -f dx/drho, x measured in the parent's end frame. Throws SolverError beyond 175 deg, or
/// if the child's x axis points along the parent's z.
Vec6 wrench_of(const TurnSpring& spring, double t, const JointPoint& parent, const JointPoint& child,
               const std::string& name, LawInRegime& law_in_regime, bool keeps_regime);

/// -L^T (K [d; theta] - preload) - D v_rel. Throws SolverError if |theta| is beyond 175 deg, where the bushing
/// resists it.
Vec6 wrench_of(const Bushing& bushing, const JointPoint& parent, const JointPoint& child, const std::string& name);

}  // namespace concord::relative
