#include "compare/invariance/laws.h"

#include <gtest/gtest.h>

namespace concord::compare::invariance {
namespace {

/// A law with all that a law may have, nothing of it symmetric.
ForceLaw full_law() {
  ForceLaw law;
  law.stiffness = 3.0;
  law.damping = 0.7;
  law.free = 0.2;
  law.preload = 1.1;
  law.spring_table = ForceTable({-1.0, -0.2, 0.1, 0.8, 1.5}, {-2.0, -0.7, 0.3, 0.9, 4.0});
  law.damper_table = ForceTable({-2.0, -0.5, 0.3, 1.0, 3.0}, {-1.0, -0.4, 0.1, 0.6, 0.7});
  law.lower = SmoothStop{-0.6, 50.0, 2.0, 0.1};
  law.upper = SmoothStop{0.9, 80.0, 3.0, 0.2};
  law.actuator = Harmonic{0.3, 1.2, 4.0, 0.5};
  return law;
}

std::vector<TimeFunction> laws_of_time() {
  return {ConstantSpeed{0.4, 1.3}, Polynomial{{0.2, -0.3, 0.5}}, Harmonic{0.3, 1.2, 4.0, 0.5},
          SmoothStep{0.1, 0.8, -0.4, 0.9}, SplineTable({0.0, 0.3, 0.5, 0.9, 1.2}, {0.1, 0.5, -0.2, 0.4, 0.6})};
}

constexpr double kNear = 1e-12;

// Detects a part of a law that keeps its sign when the coordinate changes sign: stops not exchanged, a table not turned
// round, a preload forgotten.
TEST(InvarianceLaws, MirroredLawResistsTheMirroredCoordinate) {
  const ForceLaw law = full_law();
  const ForceLaw other = mirrored(law);
  for (const double x : {-1.4, -0.65, 0.0, 0.3, 0.95, 1.7}) {
    for (const double xdot : {-2.5, -0.1, 0.8, 3.5}) {
      const Resistance one = evaluate_resistance(law, x, xdot);
      const Resistance two = evaluate_resistance(other, -x, -xdot);
      EXPECT_NEAR(two.force, -one.force, kNear * (1.0 + std::abs(one.force))) << x << ' ' << xdot;
      EXPECT_NEAR(two.over_x, one.over_x, kNear * (1.0 + std::abs(one.over_x)));
      EXPECT_NEAR(two.over_xdot, one.over_xdot, kNear * (1.0 + std::abs(one.over_xdot)));
    }
  }
  EXPECT_NEAR(evaluate_actuator(other, 0.3), -evaluate_actuator(law, 0.3), kNear);
}

// Detects a stop or a free length that stays where it was when the coordinate counts from elsewhere.
TEST(InvarianceLaws, ShiftedLawResistsTheShiftedCoordinate) {
  const ForceLaw law = full_law();
  const ForceLaw other = shifted(law, 0.37);
  for (const double x : {-1.4, -0.65, 0.0, 0.95, 1.7}) {
    const double force = evaluate_resistance(law, x, 0.8).force;
    EXPECT_NEAR(evaluate_resistance(other, x + 0.37, 0.8).force, force, kNear * (1.0 + std::abs(force)));
  }
}

// Detects a law of time whose derivatives do not follow its value.
TEST(InvarianceLaws, LawsOfTimeAreScaledAndShifted) {
  for (const TimeFunction& law : laws_of_time()) {
    for (const double t : {0.05, 0.4, 1.1}) {
      const TimeFunctionValue one = evaluate(law, t);
      const TimeFunctionValue by = evaluate(shifted(law, 0.37), t);
      EXPECT_NEAR(by.f, one.f + 0.37, kNear);
      EXPECT_NEAR(by.fdot, one.fdot, 1e-10);
      const TimeFunctionValue scaled_one = evaluate(scaled(law, -3.0, 1000.0), 1000.0 * t);
      EXPECT_NEAR(scaled_one.f, -3.0 * one.f, kNear);
      EXPECT_NEAR(scaled_one.fdot, -3e-3 * one.fdot, 1e-10);
      EXPECT_NEAR(scaled_one.fddot, -3e-6 * one.fddot, 1e-10);
    }
  }
}

}  // namespace
}  // namespace concord::compare::invariance
