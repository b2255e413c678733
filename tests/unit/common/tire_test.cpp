#include "common/elements/tire.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/elements/force_element.h"

namespace concord {
namespace {

Tire make_tire() {
  Tire tire;
  tire.road = std::make_shared<const Road>(Road{"bump", HalfSineBump{.start = 3.0, .length = 0.5, .height = 0.02}});
  tire.radius = 0.3;
  tire.stiffness = 2e5;
  tire.damping = 400.0;
  tire.slip_stiffness = 5e4;
  tire.cornering_stiffness = 3e4;
  tire.friction = 0.9;
  tire.speed_scale = 0.1;
  return tire;
}

/// Rolls on the road before the bump; both slips are small.
const TireContact kRolling{.x = 1.0, .delta = 0.015, .deltadot = -0.2, .V_x = 8.0, .V_y = 0.1, .s_x = 0.05};

const TireRegime kGrips{.stretch = 0, .touches = true, .pushes = true, .slides = false};
const TireRegime kSlides{.stretch = 0, .touches = true, .pushes = true, .slides = true};

double limit(const Tire& tire, double N) { return tire.friction * N; }

TEST(Tire, HasTheForcesOfItsLawsByHand) {
  const Tire tire = make_tire();
  EXPECT_EQ(regime_at(tire, kRolling), kGrips);
  const TireForces forces = evaluate(tire, kGrips, kRolling);
  EXPECT_NEAR(forces.N, 2e5 * 0.015 - 400.0 * 0.2, 1e-11);
  const double V = std::sqrt(64.0 + 0.01);
  EXPECT_NEAR(forces.F_x, -5e4 * 0.05 / V, 1e-11);
  EXPECT_NEAR(forces.F_y, -3e4 * 0.1 / V, 1e-11);
}

TEST(Tire, SlidesAtTheFrictionLimitInTheDirectionOfTheLinearForces) {
  const Tire tire = make_tire();
  TireContact contact = kRolling;
  contact.s_x = -1.1;
  contact.V_y = 0.7;
  const TireForces linear = evaluate(tire, kGrips, contact);
  const double size = std::hypot(linear.F_x, linear.F_y);
  TireRegime slides = kSlides;
  slides.along_x = linear.F_x / size;
  slides.along_y = linear.F_y / size;
  EXPECT_EQ(regime_at(tire, contact), slides);
  const TireForces forces = evaluate(tire, kSlides, contact);
  EXPECT_EQ(forces.N, linear.N);
  EXPECT_NEAR(std::hypot(forces.F_x, forces.F_y), limit(tire, forces.N), 1e-11);
  EXPECT_NEAR(forces.F_x * linear.F_y, forces.F_y * linear.F_x, 1e-6 * std::abs(linear.F_x * linear.F_y));
  EXPECT_GT(forces.F_x, 0.0);
  EXPECT_LT(forces.F_y, 0.0);
}

TEST(Tire, ALockedWheelCreepsAtStandstill) {
  // The statement's figure: the force along the road over slip_stiffness, times speed_scale.
  const Tire tire = make_tire();
  const double force = 400.0;
  TireContact contact{.x = 1.0, .delta = 0.015, .deltadot = 0.0, .V_x = 0.0, .V_y = 0.0, .s_x = 0.0};
  contact.V_x = contact.s_x = force * tire.speed_scale / tire.slip_stiffness;
  EXPECT_NEAR(evaluate(tire, kGrips, contact).F_x, -force, 1e-4 * force);
  EXPECT_NEAR(contact.s_x, 8e-4, 1e-15);
  contact.V_x = contact.s_x = 0.0;
  contact.V_y = force * tire.speed_scale / tire.cornering_stiffness;
  EXPECT_NEAR(evaluate(tire, kGrips, contact).F_y, -force, 1e-9);
}

TEST(Tire, OpposesTheMotionOfEitherDirection) {
  const Tire tire = make_tire();
  for (const double sign : {1.0, -1.0}) {
    TireContact contact = kRolling;
    contact.V_x = 8.0 * -sign;
    contact.V_y = 0.1 * sign;
    contact.s_x = 0.05 * sign;
    const TireForces forces = evaluate(tire, kGrips, contact);
    EXPECT_LT(forces.F_x * sign, 0.0);
    EXPECT_LT(forces.F_y * sign, 0.0);
  }
}

TEST(Tire, NeitherTouchesInTheAirNorPullsOnRebound) {
  const Tire tire = make_tire();
  TireContact contact = kRolling;
  contact.delta = -0.001;
  contact.deltadot = 5.0;  // falls: the damper alone would push
  EXPECT_EQ(regime_at(tire, contact), (TireRegime{.stretch = 0}));
  contact.delta = 0.001;
  contact.deltadot = -1.0;  // springs back faster than the spring follows
  const TireRegime regime = regime_at(tire, contact);
  EXPECT_EQ(regime, (TireRegime{.stretch = 0, .touches = true}));
  const TireForces forces = evaluate(tire, regime, contact);
  EXPECT_EQ(forces.N, 0.0);
  EXPECT_EQ(forces.F_x, 0.0);
  EXPECT_EQ(forces.F_y, 0.0);
}

TEST(Tire, IsRegularAtStandstill) {
  const Tire tire = make_tire();
  TireContact contact = kRolling;
  contact.V_x = contact.V_y = contact.s_x = 0.0;
  EXPECT_EQ(regime_at(tire, contact), kGrips);
  const TireForces rest = evaluate(tire, kGrips, contact);
  EXPECT_EQ(rest.F_x, 0.0);
  EXPECT_EQ(rest.F_y, 0.0);
  contact.s_x = 1e-3;
  contact.V_y = -1e-3;
  EXPECT_NEAR(evaluate(tire, kGrips, contact).F_x, -5e4 * 1e-3 / 0.1, 1e-11) << "over the speed scale";
  EXPECT_NEAR(evaluate(tire, kGrips, contact).F_y, 3e4 * 1e-3 / 0.1, 1e-11);
}

TEST(Tire, ForcesOfARegimeGoOnSmoothlyBeyondItsEnds) {
  const Tire tire = make_tire();
  constexpr double h = 1e-6;
  for (const TireRegime& regime : {kGrips, kSlides}) {
    // Through the friction limit, and through zero deflection.
    for (const double s_x : {0.2, 0.43, 0.8}) {
      for (const double delta : {0.015, 0.0, -0.002}) {
        TireContact contact = kRolling;
        contact.s_x = s_x;
        contact.delta = delta;
        const auto at = [&](double step) {
          TireContact moved = contact;
          moved.s_x += step;
          moved.delta += 0.01 * step;
          return evaluate(tire, regime, moved);
        };
        const TireForces before = at(-h);
        const TireForces here = at(0.0);
        const TireForces behind = at(h);
        EXPECT_NEAR(before.N - 2.0 * here.N + behind.N, 0.0, 1e-9);
        EXPECT_NEAR(before.F_x - 2.0 * here.F_x + behind.F_x, 0.0, 1e-5) << "no kink at " << s_x << ", " << delta;
        EXPECT_NEAR(before.F_y - 2.0 * here.F_y + behind.F_y, 0.0, 1e-5) << "no kink at " << s_x << ", " << delta;
      }
    }
  }
}

// A relay in the middle of a step: each result of the extrapolated midpoint rule lies on the same side of it.
TEST(Tire, FrictionDoesNotTurnAboutWithinARegime) {
  const Tire tire = make_tire();
  TireContact contact = kRolling;
  contact.V_y = 0.0;
  contact.s_x = 2.0;
  const TireRegime regime = regime_at(tire, contact);
  ASSERT_TRUE(regime.slides);
  EXPECT_EQ(regime.along_x, -1.0);
  const TireForces ahead = evaluate(tire, regime, contact);
  EXPECT_GT(event_function_of(tire, regime, contact), 0.0);
  contact.s_x = -2.0;
  EXPECT_EQ(evaluate(tire, regime, contact).F_x, ahead.F_x);
  EXPECT_LT(event_function_of(tire, regime, contact), 0.0) << "though it slides";
  EXPECT_EQ(evaluate(tire, regime_at(tire, contact), contact).F_x, -ahead.F_x);
  TireRegime turned = regime;
  turned.along_x = 1.0;
  EXPECT_EQ(regime_at(tire, contact), turned);
}

// A jump there, just behind the end of the regime, costs the integrator as many steps as it is let.
TEST(Tire, FrictionJumpsNowhereWhereTheSlipTurnsByARightAngle) {
  const Tire tire = make_tire();
  TireContact contact = kRolling;
  const auto turn = [&](double angle) {  // linear slip forces of one size, turned
    const double V = std::hypot(contact.V_x, tire.speed_scale);
    contact.s_x = -std::cos(angle) * 8e3 * V / tire.slip_stiffness;
    contact.V_y = -std::sin(angle) * 8e3 * V / tire.cornering_stiffness;
  };
  turn(0.3);
  const TireRegime regime = regime_at(tire, contact);
  ASSERT_TRUE(regime.slides);
  const double right = 0.3 + 0.5 * std::numbers::pi;
  turn(right - 1e-7);
  const TireForces before = evaluate(tire, regime, contact);
  EXPECT_GT(event_function_of(tire, regime, contact), 0.0);
  turn(right + 1e-7);
  const TireForces behind = evaluate(tire, regime, contact);
  EXPECT_LT(event_function_of(tire, regime, contact), 0.0);
  const double size = std::hypot(before.F_x, before.F_y);
  EXPECT_NEAR(behind.F_x, before.F_x, 1e-6 * size);
  EXPECT_NEAR(behind.F_y, before.F_y, 1e-6 * size);
  turn(2.0);
  const TireForces beyond = evaluate(tire, regime, contact);
  EXPECT_GT(regime.along_x * beyond.F_x + regime.along_y * beyond.F_y, 0.0);
  EXPECT_NEAR(std::hypot(beyond.F_x, beyond.F_y), size, 1e-12 * size);
}

/// Where a regime ends along s: the place where its margin vanishes, by bisection between a place inside and one
/// outside.
template <class Contact>
double end_between(const Tire& tire, const TireRegime& regime, double inside, double outside, const Contact& at) {
  EXPECT_GT(event_function_of(tire, regime, at(inside)), 0.0);
  EXPECT_LT(event_function_of(tire, regime, at(outside)), 0.0);
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (inside + outside);
    (event_function_of(tire, regime, at(middle)) > 0.0 ? inside : outside) = middle;
  }
  return inside;
}

void expect_same_forces(const TireForces& a, const TireForces& b) {
  EXPECT_NEAR(a.N, b.N, 1e-8);
  EXPECT_NEAR(a.F_x, b.F_x, 1e-8);
  EXPECT_NEAR(a.F_y, b.F_y, 1e-8);
}

TEST(Tire, GripEndsAtTheFrictionLimitWithAKink) {
  const Tire tire = make_tire();
  const auto at = [](double s_x) {
    TireContact contact = kRolling;
    contact.s_x = s_x;
    return contact;
  };
  const double end = end_between(tire, kGrips, 0.05, 1.0, at);
  EXPECT_NEAR(end_between(tire, kSlides, 1.0, 0.05, at), end, 1e-12) << "both regimes end there";
  expect_same_forces(evaluate(tire, kGrips, at(end)), evaluate(tire, kSlides, at(end)));
  const TireForces forces = evaluate(tire, kGrips, at(end));
  EXPECT_NEAR(std::hypot(forces.F_x, forces.F_y), limit(tire, forces.N), 1e-8);
  constexpr double h = 1e-5;
  const double grip_slope = (evaluate(tire, kGrips, at(end + h)).F_x - forces.F_x) / h;
  const double slide_slope = (evaluate(tire, kSlides, at(end + h)).F_x - forces.F_x) / h;
  EXPECT_LT(grip_slope, 10.0 * slide_slope) << "the force stops to grow";
}

TEST(Tire, PushEndsWhereTheNormalForceVanishes) {
  const Tire tire = make_tire();
  const auto at = [](double deltadot) {
    TireContact contact = kRolling;
    contact.s_x = contact.V_y = 0.0;
    contact.deltadot = deltadot;
    return contact;
  };
  const TireRegime lets_go{.stretch = 0, .touches = true};
  const double end = end_between(tire, kGrips, 0.0, -20.0, at);
  EXPECT_NEAR(end, -2e5 * 0.015 / 400.0, 1e-10);
  EXPECT_NEAR(end_between(tire, lets_go, -20.0, 0.0, at), end, 1e-10);
  expect_same_forces(evaluate(tire, kGrips, at(end)), {});
}

TEST(Tire, ContactEndsWhereTheDeflectionVanishes) {
  const Tire tire = make_tire();
  const auto at = [](double delta) {
    TireContact contact = kRolling;
    contact.s_x = contact.V_y = 0.0;
    contact.deltadot = 0.3;
    contact.delta = delta;
    return contact;
  };
  EXPECT_NEAR(end_between(tire, kGrips, 0.01, -0.01, at), 0.0, 1e-15);
  EXPECT_NEAR(end_between(tire, TireRegime{}, -0.01, 0.01, at), 0.0, 1e-15);
  EXPECT_NEAR(evaluate(tire, kGrips, at(0.0)).N, 400.0 * 0.3, 1e-12) << "a damped tire lands with a jump";
}

TEST(Tire, AStretchEndsWhereTheCentreStandsOverAnEdge) {
  const Tire tire = make_tire();
  const auto at = [](double x) {
    TireContact contact = kRolling;
    contact.x = x;
    return contact;
  };
  TireRegime regime = kGrips;
  EXPECT_NEAR(end_between(tire, regime, 2.9, 3.1, at), 3.0, 1e-14);
  regime.stretch = 1;
  EXPECT_NEAR(end_between(tire, regime, 3.1, 2.9, at), 3.0, 1e-14);
  EXPECT_NEAR(end_between(tire, regime, 3.4, 3.6, at), 3.5, 1e-14);
  regime.stretch = 2;
  EXPECT_NEAR(end_between(tire, regime, 3.6, 3.4, at), 3.5, 1e-14);
  for (const double x : {2.0, 3.2, 4.0}) {
    EXPECT_GT(event_function_of(tire, regime_at(tire, at(x)), at(x)), 0.0) << "each contact is inside its own regime";
  }
}

TEST(Tire, MarginIsTheSmallestOfAllEndsInUnitsOfTheTire) {
  const Tire tire = make_tire();
  TireContact contact = kRolling;
  contact.x = 2.9997;
  EXPECT_NEAR(event_function_of(tire, kGrips, contact), 0.0003 / 0.3, 1e-14) << "the edge is nearest";
  contact.x = 1.0;
  const TireForces forces = evaluate(tire, kGrips, contact);
  const double room = limit(tire, forces.N) - std::hypot(forces.F_x, forces.F_y);
  const double speed = std::hypot(contact.V_x, tire.speed_scale) / tire.speed_scale;
  const auto ends = event_functions_of(tire, kGrips, contact);
  EXPECT_NEAR(ends[4], speed * room / (2e5 * 0.3), 1e-12) << "of sliding";
  EXPECT_EQ(event_function_of(tire, kGrips, contact), *std::min_element(ends.begin(), ends.end()));
}

TEST(Tire, HasOneEndOnTheWheel) {
  Tire tire = make_tire();
  tire.wheel.body = 4;
  const ForceElement element{.name = "tire", .what = tire, .where = {}};
  EXPECT_EQ(end_of(element, Side::parent), nullptr);
  EXPECT_EQ(end_of(element, Side::child)->body, 4);
}

}  // namespace
}  // namespace concord
