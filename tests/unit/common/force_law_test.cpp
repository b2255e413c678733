#include "common/laws/force_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "common/elements/force_element.h"

namespace concord {
namespace {

/// Everything at once: straight lines, curved tables, both stops.
ForceLaw rich_law() {
  ForceLaw law;
  law.stiffness = 120.0;
  law.damping = 3.0;
  law.free = 0.4;
  law.preload = 7.0;
  law.spring_table = ForceTable({-0.3, -0.1, 0.05, 0.2, 0.5}, {-40.0, -9.0, 1.0, 8.0, 70.0});
  law.damper_table = ForceTable({-2.0, -0.5, 0.0, 0.7, 1.5}, {-5.0, -3.0, 0.0, 2.0, 2.5});
  law.lower = SmoothStop{.at = 0.2, .stiffness = 900.0, .damping = 11.0, .width = 0.03};
  law.upper = SmoothStop{.at = 0.7, .stiffness = 700.0, .damping = 13.0, .width = 0.05};
  return law;
}

/// Derivative by central differences of fourth order.
template <class Function>
double slope_of(const Function& f, double x) {
  constexpr double h = 1e-3;
  return (8.0 * (f(x + h) - f(x - h)) - (f(x + 2.0 * h) - f(x - 2.0 * h))) / (12.0 * h);
}

TEST(ForceLaw, SlopesAreThoseByDifferences) {
  const ForceLaw law = rich_law();
  // Below, inside and above the stops, outside the tables, away from the knots where differences see a kink.
  for (const double x : {-0.5, 0.12, 0.185, 0.25, 0.41, 0.53, 0.65, 0.72, 0.8, 1.3}) {
    for (const double xdot : {-3.1, -1.2, -0.3, 0.2, 1.1, 2.4}) {
      const Resistance found = evaluate_resistance(law, x, xdot);
      EXPECT_NEAR(found.over_x, slope_of([&](double z) { return evaluate_resistance(law, z, xdot).force; }, x), 2e-5)
          << x << ", " << xdot;
      EXPECT_NEAR(found.over_xdot, slope_of([&](double z) { return evaluate_resistance(law, x, z).force; }, xdot), 1e-8)
          << x << ", " << xdot;
    }
  }
}

TEST(ForceLaw, AddsItsPartsUp) {
  ForceLaw law = rich_law();
  const Resistance whole = evaluate_resistance(law, 0.5, 0.7);
  // Between the stops; the tables are met at a knot of the rate, and beyond the last one of the stretch.
  EXPECT_NEAR(whole.force, 7.0 + 120.0 * 0.1 + 3.0 * 0.7 + law.spring_table->evaluate(0.1) + 2.0, 1e-13);
  law.spring_table.reset();
  law.damper_table.reset();
  // Pressed fully: the straight part of a stop stands half its width behind its place.
  EXPECT_NEAR(evaluate_resistance(law, 0.9, 2.0).force, 7.0 + 120.0 * 0.5 + 6.0 + 700.0 * (0.2 - 0.025) + 26.0, 1e-12);
  EXPECT_NEAR(evaluate_resistance(law, 0.1, 2.0).force, 7.0 - 120.0 * 0.3 + 6.0 - 900.0 * (0.1 - 0.015) + 22.0, 1e-12);
}

TEST(ForceLaw, SaysNothingWhereNothingIsSaid) {
  const Resistance none = evaluate_resistance({}, 0.3, -2.0);
  EXPECT_EQ(none.force, 0.0);
  EXPECT_EQ(none.over_x, 0.0);
  EXPECT_EQ(none.over_xdot, 0.0);
  EXPECT_EQ(evaluate_actuator({}, 1.0), 0.0);
}

/// Largest jump of a function between neighbours at a place, from both sides.
template <class Function>
double jump(const Function& f, double x) {
  constexpr double h = 1e-9;
  return std::abs(f(x + h) - f(x - h));
}

TEST(ForceLaw, StopsAreSmoothWhereTheyBeginAndWhereTheyAreFull) {
  ForceLaw law;
  law.lower = rich_law().lower;
  law.upper = rich_law().upper;
  const auto force = [&](double x) { return evaluate_resistance(law, x, 0.8).force; };
  const auto stiffness = [&](double x) { return evaluate_resistance(law, x, 0.8).over_x; };
  // At rest the slope of the stiffness exists too.
  const auto bend = [&](double x) {
    constexpr double h = 1e-7;
    return (evaluate_resistance(law, x + h, 0.0).over_x - evaluate_resistance(law, x - h, 0.0).over_x) / (2.0 * h);
  };
  for (const double place : {0.2, 0.17, 0.7, 0.75}) {
    EXPECT_LT(jump(force, place), 1e-5) << place;
    EXPECT_LT(jump(stiffness, place), 1e-2) << place;
    EXPECT_LT(std::abs(bend(place)), 1.0) << place << ": at its peak it is 1.5 k / w = 45000";
  }
  EXPECT_EQ(force(0.45), 0.0);
  EXPECT_LT(force(0.1), 0.0) << "a lower stop pushes up";
  EXPECT_GT(force(0.8), 0.0) << "an upper stop pulls down";
}

TEST(ForceLaw, StopsStoreWhatTheyReturn) {
  // Without damping the force is the slope of an energy: pressed in and let out, no work is left.
  ForceLaw law;
  law.upper = SmoothStop{.at = 0.1, .stiffness = 500.0, .damping = 0.0, .width = 0.04};
  for (const double x : {0.105, 0.12, 0.2}) {
    EXPECT_EQ(evaluate_resistance(law, x, 1.0).force, evaluate_resistance(law, x, -1.0).force);
  }
}

/// A damped stop that is pressed by p and left or met at the rate pdot.
double stop_force(const ForceLaw& law, double p, double pdot) {
  return evaluate_resistance(law, law.upper->at + p, pdot).force;
}

ForceLaw stopped_law() {
  ForceLaw law;
  law.upper = SmoothStop{.at = 0.3, .stiffness = 800.0, .damping = 25.0, .width = 0.02};
  law.lower = SmoothStop{.at = -0.1, .stiffness = 600.0, .damping = 35.0, .width = 0.05};
  return law;
}

TEST(ForceLaw, AStopPushesAndNeverPulls) {
  const ForceLaw law = stopped_law();
  for (double x = -0.4; x < 0.6; x += 0.0071) {
    for (const double xdot : {-9.0, -1.0, -0.2, 0.0, 0.3, 7.0}) {
      const Resistance found = evaluate_resistance(law, x, xdot);
      EXPECT_GE(x > 0.1 ? found.force : -found.force, 0.0) << x << ", " << xdot;
    }
  }
  // Pressed fully by 0.05: 800 (0.05 - 0.01) = 32 N of the spring, so it lets go where it is left at 1.28 m/s.
  EXPECT_NEAR(stop_force(law, 0.05, -1.27), 0.25, 1e-12);
  EXPECT_EQ(stop_force(law, 0.05, -1.29), 0.0);
  EXPECT_EQ(evaluate_resistance(law, 0.35, -1.29).over_x, 0.0);
}

TEST(ForceLaw, RegimesOfStopsEndWhereTheirMarginsVanish) {
  const ForceLaw law = stopped_law();
  const auto regime = [&](double p, double pdot) { return regime_at(law, law.upper->at + p, pdot).upper; };
  EXPECT_EQ(regime(-0.001, 3.0), StopRegime::off);
  EXPECT_EQ(regime(0.001, 3.0), StopRegime::soft);
  EXPECT_EQ(regime(0.021, 0.0), StopRegime::full);
  EXPECT_EQ(regime(0.01, -5.0), StopRegime::off) << "it has let go";
  // Along a motion into the stop and out of it, the margin of the regime at its begin falls through zero just where
  // the regime at the moment becomes another one.
  const auto p_of = [](double t) { return 0.06 - 30.0 * t * t; };
  const auto pdot_of = [](double t) { return -60.0 * t; };
  LawRegime held = regime_at(law, 0.3 + p_of(-0.05), pdot_of(-0.05));
  std::vector<StopRegime> met{held.upper};
  for (double t = -0.05; t < 0.05; t += 1e-5) {
    const double value = event_function_of(law, held, 0.3 + p_of(t), pdot_of(t));
    const LawRegime now = regime_at(law, 0.3 + p_of(t), pdot_of(t));
    EXPECT_EQ(value < 0.0, now.upper != held.upper) << t;
    if (value < 0.0) met.push_back(now.upper);
    held = now;
  }
  EXPECT_EQ(met, (std::vector<StopRegime>{StopRegime::off, StopRegime::soft, StopRegime::full, StopRegime::off}));
}

TEST(ForceLaw, RegimesGoOnBeyondTheirEndsAsOneFormula) {
  // A step may look beyond the end of a regime: there is no jump, and where a stop rests on a border nothing chatters.
  const ForceLaw law = stopped_law();
  const LawRegime soft{.lower = StopRegime::off, .upper = StopRegime::soft};
  const LawRegime full{.lower = StopRegime::off, .upper = StopRegime::full};
  const double border = law.upper->at + law.upper->width;
  EXPECT_NEAR(evaluate_resistance(law, soft, border, 0.4).force, evaluate_resistance(law, full, border, 0.4).force,
              1e-12);
  EXPECT_GT(event_function_of(law, soft, border, 0.4), 0.0);
  EXPECT_GT(event_function_of(law, full, border, 0.4), 0.0);
  EXPECT_LT(event_function_of(law, soft, border + 1e-9, 0.4), 0.0);
  EXPECT_LT(event_function_of(law, full, border - 1e-9, 0.4), 0.0);
  EXPECT_EQ(event_function_of(ForceLaw{}, LawRegime{}, 0.3, 1.0), std::numeric_limits<double>::infinity());
}

TEST(ForceTable, MeetsItsPointsAndGoesOnStraight) {
  const std::vector<double> x{-0.3, -0.1, 0.05, 0.2, 0.5};
  const std::vector<double> force{-40.0, -9.0, 1.0, 8.0, 70.0};
  const ForceTable table(x, force);
  for (std::size_t k = 0; k < x.size(); ++k) EXPECT_NEAR(table.evaluate(x[k]), force[k], 1e-13);
  const auto value = [&](double z) { return table.evaluate(z); };
  const auto slope = [&](double z) { return table.slope(z); };
  for (const double end : {-0.3, 0.5}) {
    EXPECT_LT(jump(value, end), 1e-6);
    EXPECT_LT(jump(slope, end), 1e-4);
  }
  EXPECT_NEAR(table.evaluate(0.9), 70.0 + 0.4 * table.slope(0.5), 1e-12);
  EXPECT_NEAR(table.evaluate(-0.8), -40.0 - 0.5 * table.slope(-0.3), 1e-12);
  EXPECT_EQ(table.slope(3.0), table.slope(0.5));
}

TEST(ForceTable, IsExactForCubics) {
  const auto cubic = [](double z) { return 2.0 - z + 3.0 * z * z - 5.0 * z * z * z; };
  const std::vector<double> x{-1.0, -0.2, 0.3, 0.9, 1.4};
  std::vector<double> force;
  for (const double z : x) force.push_back(cubic(z));
  const ForceTable table(x, force);
  for (const double z : {-0.9, -0.1, 0.5, 1.3}) EXPECT_NEAR(table.evaluate(z), cubic(z), 1e-13);
}

TEST(ForceElement, NamesItsEnds) {
  LineSpring spring;
  spring.ends[0].body = 3;
  spring.ends[1].body = 5;
  const ForceElement line{.name = "coil", .what = spring, .where = {}};
  EXPECT_EQ(end_of(line, Side::parent)->body, 3);
  EXPECT_EQ(end_of(line, Side::child)->body, 5);
  Load load;
  load.at.body = 2;
  const ForceElement push{.name = "push", .what = load, .where = {}};
  EXPECT_EQ(end_of(push, Side::parent), nullptr);
  EXPECT_EQ(end_of(push, Side::child)->body, 2);
}

/// Held beyond its border, a piece of a table goes on as its own cubic: smooth through the knot.
TEST(ForceLaw, TablesGoOnInTheirPieceWhileItIsHeld) {
  ForceLaw law;
  law.free = 0.2;
  law.spring_table.emplace(std::vector{-1.0, -0.6, 0.1, 0.5, 0.8, 1.4}, std::vector{-3.0, -1.0, 0.2, 1.5, 1.7, 4.0});
  const LawRegime held = regime_at(law, 0.2 + 0.3, 0.0);
  const auto third_difference = [&](double from, double h, const LawRegime* regime) {
    const auto f = [&](int k) {
      const double x = 0.2 + from + k * h;
      return (regime != nullptr ? evaluate_resistance(law, *regime, x, 0.0) : evaluate_resistance(law, x, 0.0)).force;
    };
    return (f(3) - 3.0 * f(2) + 3.0 * f(1) - f(0)) / (h * h * h);
  };
  const double inside = third_difference(0.2, 0.05, &held);
  EXPECT_NEAR(third_difference(0.42, 0.05, &held), inside, 1e-9 * std::abs(inside)) << "across the knot at 0.5";
  EXPECT_GT(std::abs(third_difference(0.42, 0.05, nullptr) - inside), 1e-2 * std::abs(inside));
  EXPECT_TRUE(has_regimes(law));
  EXPECT_NEAR(event_function_of(law, held, 0.2 + 0.4, 0.0), 0.1 / 2.4, 1e-10);
  EXPECT_LT(event_function_of(law, held, 0.2 + 0.5 + 1e-9, 0.0), 0.0);
  EXPECT_GT(event_function_of(law, held, 0.2 + 0.5, 0.0), 0.0) << "what rests on a knot does not chatter";
}

/// Outside the table its tangents hold, each a piece of its own.
TEST(ForceLaw, TangentsOfATableAreRegimes) {
  ForceLaw law;
  law.damper_table.emplace(std::vector{-2.0, -0.5, 0.4, 1.5}, std::vector{-4.0, -1.8, 1.5, 3.0});
  for (const double beyond : {-2.7, 1.9}) {
    const LawRegime outside = regime_at(law, 0.0, beyond);
    EXPECT_GT(event_function_of(law, outside, 0.0, beyond), 0.0);
    EXPECT_LT(event_function_of(law, outside, 0.0, 0.3), 0.0);
    EXPECT_EQ(evaluate_resistance(law, outside, 0.0, beyond).force, law.damper_table->evaluate(beyond));
  }
}

/// The force of a regime that has ended is not that of the law.
TEST(ForceLaw, DepartsFromItselfInARegimeThatHasEnded) {
  ForceLaw law;
  law.upper = SmoothStop{0.5, 2000.0, 10.0, 0.1};
  law.spring_table.emplace(std::vector{-2.0, -0.5, 0.0, 0.2, 0.4, 1.5},
                           std::vector{-40.0, -18.0, 2.0, 3.0, 15.0, 30.0});
  for (const double x : {0.1, 0.45, 0.55, 0.7}) {
    for (const double xdot : {-1.0, 0.0, 1.0}) {
      EXPECT_EQ(departure_of(law, regime_at(law, x, xdot), x, xdot), 0.0);
    }
  }
  const LawRegime away = regime_at(law, 0.41, 0.0);
  const double pressed = evaluate_resistance(law, 0.6, 0.0).force - evaluate_resistance(law, away, 0.6, 0.0).force;
  EXPECT_NEAR(departure_of(law, away, 0.6, 0.0), pressed / (2000.0 * 0.1), 1e-12);
  EXPECT_GT(departure_of(law, away, 0.6, 0.0), kLargestDeparture);
  LawRegime other_piece = away;
  other_piece.spring_piece = regime_at(law, -1.0, 0.0).spring_piece;
  EXPECT_GT(departure_of(law, other_piece, 0.41, 0.0), kLargestDeparture);
}

/// Nothing is left of the border of a regime that rests on it.
TEST(ForceLaw, HardlyDepartsFromItselfBesideTheEndOfARegime) {
  ForceLaw law;
  law.lower = SmoothStop{-0.5, 2000.0, 10.0, 0.1};
  const LawRegime away = regime_at(law, 0.0, 0.0);
  EXPECT_LT(departure_of(law, away, -0.5 - 1e-12, 0.0), 1e-20);
  EXPECT_EQ(departure_of(ForceLaw{}, {}, 0.3, 0.1), 0.0);
}

}  // namespace
}  // namespace concord
