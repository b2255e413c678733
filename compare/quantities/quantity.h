#pragma once

#include <compare>

#include "common/results.h"

/// One number that is compared.
namespace concord::compare {

enum class Kind {
  reaction,         // of a joint on a side, at that side's point, in that side's joint frame
  reaction_global,  // the same in global axes
  total,            // total wrench: reaction and coordinate wrenches
  tau,              // coordinate force on a joint speed: of driver, motor, spring, damper and couplings together
  share,            // what one of several actors exerts of it
  coupling,         // force of a coupling: factor_k times it is its part of what acts on coordinate k
  element,          // wrench of a force element on a side, at that end's point, in that end's frame
  acceleration,     // of a body: origin, angular, modal
  body_sum          // total wrench of all joints on a body, at its origin, global axes: unique even with redundancy
};

/// One number that both solvers give.
struct Quantity {
  Kind kind = Kind::reaction;
  int owner = 0;                // joint, coupling, force element, or body for accelerations and sums
  Side side = Side::child;      // of wrenches
  int component = 0;            // 0..5 for wrenches; joint speed for forces on it; place in [vdot; omegadot; addot]
  Actor actor = Actor::driver;  // of a share

  friend auto operator<=>(const Quantity&, const Quantity&) = default;  // NOLINT(modernize-use-nullptr): as of indices
};

/// A force along a coordinate, or of a coupling: a number by itself, no component of a vector.
inline bool is_scalar_force(Kind kind) { return kind == Kind::tau || kind == Kind::share || kind == Kind::coupling; }

}  // namespace concord::compare
