#include "common/line_watch.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/reading/model_file.h"
#include "relative/solver.h"

namespace concord::relative {
namespace {

/// A body that a spring pulls along a tilted slide, towards and through the place where the slide's points meet.
Model pulled_on_slide(const std::string& law, double speed = 0.1) {
  return parse_model(fmt::format(R"toml(format = 1
[[body]]
name = "block"
mass = 1.3
inertia = [0.01, 0.012, 0.014]
[[joint]]
name = "slide"
type = "translational"
parent = {{ body = "ground", axis = [1, 2, 0.5], angle = 0.7 }}
child = {{ body = "block", axis = [1, 2, 0.5], angle = 0.7 }}
start.slide_z = {{ keep = 0.8, keep_speed = {} }}
[[line_spring]]
name = "cord"
parent = "ground"
child = "block"
{}
[run]
until = 4
)toml",
                                 speed, law),
                     "pulled.toml");
}

std::string stop_of(const Model& model, double until, const std::string& integrator = "") {
  RunOptions options;
  options.until = until;
  options.samples = 40;
  options.rtol = 1e-10;
  options.integrator = integrator;
  try {
    (void)make_solver(model)->integrate(options, {});
  } catch (const SolverError& error) {
    return error.what();
  }
  return "";
}

TEST(LineWatch, EndsARunWhereTheEndsOfASpringMeet) {
  for (const std::string law : {"stiffness = 2.2\nfree = 0.3", "preload = 1.7", "actuator = 0.9",
                                "stiffness = 2.2\nfree = 0\nlower_stop = { at = 0.2, stiffness = 1, width = 0.1 }"}) {
    for (const std::string integrator : {"adams", "dirk"}) {
      const std::string stop = stop_of(pulled_on_slide(law), 4.0, integrator);
      EXPECT_TRUE(stop.starts_with("relative: at t = ")) << law << integrator << stop;
      EXPECT_NE(stop.find("'cord'"), std::string::npos) << law << integrator << stop;
      EXPECT_NE(stop.find("its force has no direction"), std::string::npos) << law << integrator << stop;
    }
  }
}

/// From rest at twice its free length the block comes to rest just where the ends meet, and turns round.
TEST(LineWatch, EndsARunWhereTheEndsTouch) {
  const std::string stop = stop_of(pulled_on_slide("stiffness = 2.2\nfree = 0.4", 0.0), 4.0);
  EXPECT_NE(stop.find("'cord'"), std::string::npos) << stop;
  EXPECT_NE(stop.find("its force has no direction"), std::string::npos) << stop;
}

/// x = x0 cos w t + ...: the force is as smooth as the place.
TEST(LineWatch, LetsASpringWithoutAJumpPass) {
  EXPECT_EQ(stop_of(pulled_on_slide("stiffness = 2.2\nfree = 0\ndamping = 0.1"), 4.0), "");
}

/// The stop of the slide itself turns the block round before the ends meet.
TEST(LineWatch, LetsASpringTurnBack) {
  Model model = pulled_on_slide("stiffness = 2.2\nfree = 0.3");
  JointSpring buffer;
  buffer.law.lower = SmoothStop{.at = 0.1, .stiffness = 4e4, .damping = 0.0, .width = 0.01};
  model.joints[0].springs = {buffer};
  EXPECT_EQ(stop_of(model, 4.0), "");
}

/// From the axis to the rim: the line turns over many times between two outputs and keeps its length.
TEST(LineWatch, LetsALineTurnFast) {
  const Model model = parse_model(R"toml(format = 1
[[body]]
name = "rotor"
mass = 2.0
inertia = [0.01, 0.012, 0.02]
[[joint]]
name = "axle"
type = "revolute"
parent = "ground"
child = "rotor"
drive.turn_z = { law = "constant_speed", speed = 731, start = 0.2 }
[[line_spring]]
name = "spoke"
parent = "ground"
child = { body = "rotor", point = [0.3, 0.1, 0.02] }
stiffness = 40
free = 0.1
[run]
until = 1
)toml",
                                  "rotor.toml");
  EXPECT_EQ(stop_of(model, 1.0), "");
}

TEST(LineWatch, ATurnSpringGoesOnThroughWholeTurns) {
  Model model = parse_model(R"toml(format = 1
gravity = [0, -9.81, 1]
[[body]]
name = "flap"
mass = 0.8
inertia = [0.002, 0.05, 0.05]
center_of_mass = [0.3, 0, 0]
[[joint]]
name = "hinge"
type = "revolute"
parent = "ground"
child = "flap"
start.turn_z = { keep = 0.4, keep_speed = 11 }
[[turn_spring]]
name = "coil"
parent = "ground"
child = "flap"
stiffness = 0.6
[run]
until = 2
)toml",
                            "flap.toml");
  EXPECT_EQ(stop_of(model, 2.0), "");
}

}  // namespace
}  // namespace concord::relative
