#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "common/error.h"
#include "judged_machines.h"

/// Balls whose three speeds the start keeps although fewer of them are free.
namespace concord::verification {
namespace {

/// A lopsided ball of radius 0.2 m that rolls on the ground while drivers move its centre: at the start with 1.8 m/s
/// along x and 0.8 m/s along y, which leaves the speed about z alone.
std::string on_driven_slides(const std::string& speeds) {
  return fmt::format(R"(format = 1
gravity = [0.3, 0.0, -9.81]
[[body]]
name = "ball"
mass = 2.2
center_of_mass = [0.0, 0.0, 0.0]
inertia = [0.02, 0.013, 0.017]
[[joint]]
name = "floor"
type = "rolling_ball"
parent = {{ body = "ground", point = [0.0, 0.0, 0.2], x = [1.0, 0.0, 0.0], z = [0.0, 0.0, 1.0] }}
child = {{ body = "ball", point = [-0.012, 0.004, 0.0], x = [1.0, 0.0, 0.0], z = [0.0, 0.0, 1.0] }}
radius = 0.2
drive.slide_x = {{ law = "harmonic", amplitude = 0.6, frequency = 3 }}
drive.slide_y = {{ law = "harmonic", amplitude = 0.4, frequency = 2 }}
start.ball = {{ keep = {{ axis = [1, 2, 0], angle = "40 deg" }}, keep_speed = [{}] }}
[run]
until = 0.6
)",
                     speeds);
}

/// A ball of a tripod at (x, y), whose start keeps or guesses y as `of_y` says, and its speed about z.
std::string tripod_ball(const std::string& name, double x, double y, const char* of_y, double spin) {
  return fmt::format(R"([[body]]
name = "{0}"
mass = 1.3
center_of_mass = [0.0, 0.0, 0.0]
inertia = [0.004, 0.005, 0.006]
[[joint]]
name = "floor of {0}"
type = "rolling_ball"
parent = {{ body = "ground", point = [0.0, 0.0, 0.1], x = [1.0, 0.0, 0.0], z = [0.0, 0.0, 1.0] }}
child = {{ body = "{0}", point = [0.0, 0.0, 0.0], x = [1.0, 0.0, 0.0], z = [0.0, 0.0, 1.0] }}
radius = 0.1
start.slide_x = {{ {6} = {1} }}
start.slide_y = {{ {3} = {2} }}
start.ball = {{ keep = {{ axis = [0, 0, 1], angle = 0 }}, keep_speed = [-1, 2, {4}] }}
[[joint]]
name = "socket of {0}"
type = "spherical"
parent = {{ body = "{0}", point = [0.0, 0.0, 0.0], x = [1.0, 0.0, 0.0], z = [0.0, 0.0, 1.0] }}
child = {{ body = "plate", point = [{1}, {2}, {5}], x = [1.0, 0.0, 0.0], z = [0.0, 0.0, 1.0] }}
)",
                     name, x, y, of_y, spin, -0.05, name == "a" ? "keep" : "guess");
}

}  // namespace

TEST_CASE("A ball on driven slides starts with three kept speeds, of which one is free, and both solvers agree",
          "[quick]") {
  const Model model = parse(on_driven_slides("-4, 9, 1.5"));
  expect_to_agree(model, in_short(model, 1.0));
}

TEST_CASE("Three balls under a plate start with all speeds kept, nine of six that are free, and both solvers agree",
          "[quick]") {
  const Model model = parse(R"(format = 1
gravity = [0.5, 0.2, -9.81]
[[body]]
name = "plate"
mass = 5.0
center_of_mass = [0.28, 0.17, 0.02]
inertia = [0.2, 0.15, 0.3]
start.pose = { origin = [0.0, 0.0, 0.15], axis = [0, 0, 1], angle = 0 }
)" + tripod_ball("a", 0.0, 0.0, "keep", 0.3) +
                            tripod_ball("b", 0.6, 0.1, "keep", 0.0) + tripod_ball("c", 0.25, 0.5, "guess", 1.0) +
                            "[run]\nuntil = 0.3\n");
  expect_to_agree(model, in_short(model, 1.0));
}

TEST_CASE("Both solvers refuse speeds of a ball that contradict the slides on which it is driven", "[quick]") {
  const Model model = parse(on_driven_slides("-4, 9.0001, 1.5"));
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    CHECK_THROWS_AS(solver->assemble(), InputError);
  }
}

}  // namespace concord::verification
