#include "common/laws/break_times.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace concord {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

SplineTable table(std::vector<double> times) {
  std::vector<double> values;
  for (const double t : times) values.push_back(t * t * t - 0.4 * t);
  return {std::move(times), std::move(values)};
}

TEST(BreakTimes, AreWhereALawGoesOnAsAnotherFormula) {
  EXPECT_THAT(break_times(SmoothStep{0.3, 0.7, -1.0, 2.0}), ElementsAre(0.3, 0.7));
  EXPECT_THAT(break_times(Harmonic{0.0, 1.0, 3.0, 0.2}), IsEmpty());
  EXPECT_THAT(break_times(table({0.0, 0.1, 0.25, 0.4, 0.7, 1.0})), ElementsAre(0.25, 0.4));
}

/// Four points carry one cubic.
TEST(BreakTimes, OneCubicHasNone) { EXPECT_THAT(break_times(table({0.0, 0.1, 0.25, 0.4})), IsEmpty()); }

TEST(BreakTimes, OfAModelRiseWithinTheRunEachOnce) {
  Model model;
  Joint joint;
  Driver driver;
  driver.law = SmoothStep{-0.2, 0.6, 0.0, 1.0};
  joint.drivers = {driver};
  JointSpring spring;
  spring.law.actuator = SmoothStep{0.6 + 1e-14, 0.9, 0.0, 1.0};
  joint.springs = {spring};
  model.joints = {joint};
  Load load;
  load.law = SmoothStep{0.1, 2.0, 0.0, 1.0};
  LineSpring strut;
  strut.law.actuator = SmoothStep{0.2, 3.0, 0.0, 1.0};
  TurnSpring coil;
  coil.law.actuator = SmoothStep{0.15, 1.0, 0.0, 1.0};
  model.elements = {{"load", load, {}}, {"strut", strut, {}}, {"coil", coil, {}}};
  EXPECT_THAT(break_times(model, 1.0), ElementsAre(0.1, 0.15, 0.2, 0.6, 0.9));
}

TEST(LawsOfTime, AreThoseThatAreNotConstant) {
  Model model;
  EXPECT_FALSE(has_laws_of_time(model));
  Load load;
  load.law = ConstantSpeed{2.0, 0.0};
  model.elements = {{"load", load, {}}};
  EXPECT_FALSE(has_laws_of_time(model));
  LineSpring strut;
  strut.law.actuator = Harmonic{0.0, 1.0, 3.0, 0.2};
  model.elements.push_back({"strut", strut, {}});
  EXPECT_TRUE(has_laws_of_time(model));
  model.elements.clear();
  Driver driver;
  driver.law = ConstantSpeed{0.0, 1e-3};
  model.joints.emplace_back().drivers = {driver};
  EXPECT_TRUE(has_laws_of_time(model));
}

}  // namespace
}  // namespace concord
