#include "compare/audit/law_of_time.h"

#include <gtest/gtest.h>

#include <cmath>

namespace concord::compare {
namespace {

/// Laws of every kind, and a time inside each piece of theirs.
std::vector<TimeFunction> all_laws() {
  return {ConstantSpeed{0.3, -1.7}, Polynomial{{0.2, -0.7, 1.1, 0.4, -0.3}}, Harmonic{0.4, 1.3, 5.2, 0.7},
          SmoothStep{0.15, 1.35, -0.8, 2.1}, SplineTable({0.1, 0.35, 0.5, 0.92, 1.3}, {0.4, -0.6, 0.9, 1.4, -0.2})};
}

TEST(LawOfTime, SaysWhatTheSolversEvaluatorSays) {
  for (const TimeFunction& stated : all_laws()) {
    const LawOfTime law(stated);
    for (const double t : {-0.4, 0.05, 0.15, 0.22, 0.5, 0.74, 1.1, 1.35, 1.9}) {
      const TimeFunctionValue other = evaluate(stated, t);
      const Moving own = law.at(t);
      EXPECT_NEAR(own.value, other.f, 1e-12) << stated.index() << ", t = " << t;
      EXPECT_NEAR(own.rate, other.fdot, 1e-11) << stated.index() << ", t = " << t;
      EXPECT_NEAR(own.rate_of_rate, other.fddot, 2e-10) << stated.index() << ", t = " << t;
    }
  }
}

TEST(LawOfTime, RatesAreThoseByDifferences) {
  for (const TimeFunction& stated : all_laws()) {
    const LawOfTime law(stated);
    for (const double t : {0.22, 0.43, 0.74, 1.1}) {
      const double h = 1e-3;
      const auto slope = [&](auto of) {
        return (8.0 * (of(t + h) - of(t - h)) - (of(t + 2.0 * h) - of(t - 2.0 * h))) / (12.0 * h);
      };
      EXPECT_NEAR(law.at(t).rate, slope([&](double at) { return law.at(at).value; }), 1e-8) << stated.index();
      EXPECT_NEAR(law.at(t).rate_of_rate, slope([&](double at) { return law.at(at).rate; }), 1e-6) << stated.index();
    }
  }
}

TEST(LawOfTime, ASmoothStepBeginsAndEndsWithThreeVanishingDerivatives) {
  const TimeFunction stated = SmoothStep{0.2, 0.7, 1.0, 3.0};
  const LawOfTime law(stated);
  // s^4 (35 - 84 s + 70 s^2 - 20 s^3) at s = 1/4.
  EXPECT_NEAR(law.at(0.325).value, 1.0 + 2.0 * 0.070556640625, 1e-14);
  EXPECT_NEAR(law.at(0.45).value, 2.0, 1e-14);
  for (const double end : {0.2, 0.7}) {
    const double inside = end + (end < 0.5 ? 1e-4 : -1e-4);
    const double s = 1e-4 / 0.5;
    EXPECT_NEAR(std::abs(law.at(inside).value - law.at(end).value), 2.0 * 35.0 * std::pow(s, 4), 1e-14);
    EXPECT_LT(std::abs(law.at(inside).rate_of_rate), 2.0 * 12.0 * 35.0 * s * s / 0.25 * 1.01);
  }
}

TEST(Spline, IsTheNotAKnotSpline) {
  // Exact for a cubic, on points that are far from even; with four points it is the cubic through them.
  const auto cubic = [](double x) { return 0.7 - 1.2 * x + 0.4 * x * x - 2.1 * x * x * x; };
  for (const std::vector<double>& x :
       {std::vector<double>{-0.9, -0.2, 0.1, 0.85}, std::vector<double>{-1.3, -1.1, -0.4, 0.0, 0.05, 0.9, 1.7}}) {
    std::vector<double> y;
    for (const double at : x) y.push_back(cubic(at));
    const Spline curve(x, y);
    for (const double at : {-1.6, -1.2, -0.33, 0.02, 0.6, 1.1, 2.0}) {
      const Moving found = curve.at(at_unit_rate(at));
      EXPECT_NEAR(found.value, cubic(at), 1e-12);
      EXPECT_NEAR(found.rate, -1.2 + 0.8 * at - 6.3 * at * at, 1e-11);
      EXPECT_NEAR(found.rate_of_rate, 0.8 - 12.6 * at, 1e-10);
    }
  }
}

TEST(Spline, HasContinuousSecondDerivativesAndThirdOnesWhereItIsNoKnot) {
  const std::vector<double> x{-0.3, -0.1, 0.05, 0.2, 0.5, 0.7};
  const Spline curve(x, {-4.0, -0.9, 0.1, 0.8, 7.0, 6.1});
  const double h = 1e-7;
  const auto bend = [&](double at) { return curve.at(at_unit_rate(at)).rate_of_rate; };
  for (const double knot : {-0.1, 0.05, 0.2, 0.5}) {
    EXPECT_NEAR(curve.at(at_unit_rate(knot - h)).rate, curve.at(at_unit_rate(knot + h)).rate, 1e-3);
    EXPECT_NEAR(bend(knot - h), bend(knot + h), 2e-2);
  }
  const auto twist = [&](double at) { return (bend(at + 0.01) - bend(at)) / 0.01; };
  EXPECT_NEAR(twist(-0.115), twist(-0.095), 1e-6 * std::abs(twist(-0.115)));
  EXPECT_NEAR(twist(0.485), twist(0.505), 1e-6 * std::abs(twist(0.485)));
  EXPECT_GT(std::abs(twist(0.035) - twist(0.055)), 1.0) << "an inner knot";
}

}  // namespace
}  // namespace concord::compare
