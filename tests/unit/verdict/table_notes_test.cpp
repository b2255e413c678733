#include "compare/verdict/table_notes.h"

#include <gtest/gtest.h>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

const std::vector<double> kX{-2.0, -0.3, -0.2, 0.2, 0.3, 2.0};

TEST(TableNotes, ACubicThatLeavesItsPointsIsTold) {
  Model model = pendulum_model();
  JointSpring spring;
  spring.law.damper_table = ForceTable(kX, {-7.0, -7.0, 0.0, 0.0, 7.0, 7.0});
  model.joints[0].springs = {spring};
  const std::vector<std::string> notes = notes_on_tables(model, model.run.until);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_TRUE(notes[0].starts_with("the damper_table of joint 'A' leaves its points: the cubic through them reaches "))
      << notes[0];
  EXPECT_NE(notes[0].find("between -7 at -2 and -7 at -0.3: give more points where it bends"), std::string::npos)
      << notes[0];
}

TEST(TableNotes, AForceElementIsNamedToo) {
  Model model = sprung_pendulum_model();
  std::get<LineSpring>(model.elements[0].what).law.spring_table = ForceTable(kX, {-7.0, -7.0, 0.0, 0.0, 7.0, 7.0});
  const std::vector<std::string> notes = notes_on_tables(model, model.run.until);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_TRUE(notes[0].starts_with("the spring_table of force element 'strut' leaves its points")) << notes[0];
}

/// A pulse between far points, as one who thinks of straight lines writes it.
TEST(TableNotes, LawsOfTimeAndRoadsAreLookedAt) {
  const SplineTable pulse({0.0, 0.5, 0.51, 0.52, 1.0}, {0.0, 0.0, 1.0, 0.0, 0.0});
  Model model = sprung_pendulum_model();
  model.run.until = 1.0;
  std::get<LineSpring>(model.elements[0].what).law.actuator = pulse;
  model.elements.push_back({"push", Load{}, {}});
  std::get<Load>(model.elements.back().what).law = pulse;
  Tire tire;
  tire.road = std::make_shared<const Road>(Road{"bump", RoadTable{pulse, 0.0, 1.0}});
  model.elements.push_back({"wheel", tire, {}});
  Driver driver;
  driver.law = pulse;
  model.joints[0].drivers = {driver};
  const std::vector<std::string> notes = notes_on_tables(model, model.run.until);
  ASSERT_EQ(notes.size(), 4U);
  EXPECT_TRUE(notes[0].starts_with("the driver of joint 'A' leaves its points")) << notes[0];
  EXPECT_TRUE(notes[1].starts_with("the actuator of force element 'strut' leaves its points")) << notes[1];
  EXPECT_TRUE(notes[2].starts_with("the law of force element 'push' leaves its points")) << notes[2];
  EXPECT_TRUE(notes[3].starts_with("the road 'bump' of force element 'wheel' leaves its points")) << notes[3];
}

TEST(TableNotes, AMotionSwingsBeyondItsPointsAndNothingCountsAfterTheRun) {
  Model model = pendulum_model();
  model.run.until = 0.5;
  Driver driver;
  driver.law = SplineTable({0.0, 0.1, 0.2, 0.3, 1e4}, {0.0, 0.4, 0.5, 0.5, 0.5});
  model.joints[0].drivers = {driver};
  EXPECT_TRUE(notes_on_tables(model, model.run.until).empty());
}

TEST(TableNotes, ATableThatStaysBetweenItsPointsIsNoNews) {
  Model model = pendulum_model();
  JointSpring spring;
  spring.law.spring_table = ForceTable({-2.0, -1.0, 0.1, 1.0, 2.0}, {-5.0, -2.0, 0.2, 2.1, 5.5});
  model.joints[0].springs = {spring};
  EXPECT_TRUE(notes_on_tables(model, model.run.until).empty());
}

TEST(TableNotes, ALawOfTimeThatEndsBeforeTheRunIsTold) {
  Model model = pendulum_model();
  Driver driver;
  driver.law = SplineTable({0.0, 1.0, 2.0, 3.0}, {0.0, 1.0, 8.0, 27.0});
  model.joints[0].drivers = {driver};
  model.run.until = 3.0;
  EXPECT_TRUE(notes_on_tables(model, model.run.until).empty());
  const std::vector<std::string> notes = notes_on_tables(model, 10.0);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0],
            "the driver of joint 'A' ends before the run: after its last point, 27 at 3 s, its last cubic goes on and "
            "reaches 1000 at 10 s: give points until then");
}

}  // namespace
}  // namespace concord::compare
