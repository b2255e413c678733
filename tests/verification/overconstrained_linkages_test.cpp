#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "compare/audit/energy.h"
#include "judged_machines.h"

/// Linkages whose constraints depend on each other on the motion, and only there: beside it their Jacobian has a larger
/// rank.
namespace concord::verification {
namespace {

/// Opposite links equal, a / sin(alpha) = b / sin(beta): moves although it has four hinges in space.
Model bennett_linkage(double guess) {
  return parse_model(fmt::format(R"toml(format = 1
gravity = [0, -9.81, 0]
[parameters]
a = 0.3
al = "40 deg"
be = "70 deg"
b = "a*sin(be)/sin(al)"
[[body]]
name = "first"
mass = 1
center_of_mass = ["a/2", 0, 0]
inertia = [1e-3, 8e-3, 8e-3]
[[body]]
name = "coupler"
mass = 1.2
center_of_mass = ["b/2", 0.02, 0]
inertia = [1e-3, 1e-2, 1e-2]
[[body]]
name = "last"
mass = 1
center_of_mass = ["a/2", 0, 0.01]
inertia = [1e-3, 8e-3, 8e-3]
[[joint]]
name = "J1"
type = "revolute"
parent = "ground"
child = "first"
start.turn_z = {{ keep = "60 deg", keep_speed = 2 }}
[[joint]]
name = "J2"
type = "revolute"
parent = {{ body = "first", point = ["a", 0, 0], axis = [1, 0, 0], angle = "al" }}
child = "coupler"
start.turn_z = {{ guess = "{} deg" }}
[[joint]]
name = "J3"
type = "revolute"
parent = {{ body = "coupler", point = ["b", 0, 0], axis = [1, 0, 0], angle = "be" }}
child = "last"
start.turn_z = {{ guess = "-60 deg" }}
[[joint]]
name = "J4"
type = "revolute"
parent = {{ body = "last", point = ["a", 0, 0], axis = [1, 0, 0], angle = "al" }}
child = {{ body = "ground", sequence = "xyz", angles = ["-be", 0, 0], point = ["-b", 0, 0] }}
)toml",
                                 guess),
                     "bennett.toml");
}

TEST_CASE("A Bennett linkage turns through its whole cycle, opposite angles alike, by every integrator", "[closure]") {
  const Model model = bennett_linkage(GENERATE(100.0, 150.0));
  for (const auto& make : {cartesian::make_solver, relative::make_solver}) {
    const auto solver = make(model);
    for (const std::string& integrator : solver->integrators()) {
      INFO(solver->name() << ", " << integrator);
      const Trajectory run = solver->integrate({1.0, 1e-11, 300, integrator}, {});
      double apart = 0.0;
      for (const Sample& sample : run.samples) {
        const auto& q = sample.state.q;
        const double opposite = q[0](0) + q[2](0);
        const double others = q[1](0) + q[3](0);
        apart = std::max({apart, std::abs(std::remainder(opposite, 2.0 * std::numbers::pi)),
                          std::abs(std::remainder(others, 2.0 * std::numbers::pi))});
      }
      CHECK(apart < 1e-11);
      // What the other integrators' steps lose adds up.
      const double allowed = integrator == solver->integrators().front() ? 1e-8 : 1e-6;
      CHECK(compare::audit_energy(model, run).relative() < allowed);
    }
  }
}

TEST_CASE("Engines whose parts are held many times over run, and both solvers find the same of their loads unique",
          "[closure]") {
  for (const std::string& name : machines_of("engines")) expect_to_agree(machine_of("engines", name), {});
}

/// A coupler on equal cranks that are all turned alike from where the machine is flat.
Model equal_cranks(int count, double turn, double arm) {
  std::string text = fmt::format(R"toml(format = 1
name = "cranks"
gravity = [0.4, -9.81, 0]
[[body]]
name = "coupler"
mass = 3
center_of_mass = [0.45, 0.02, 0]
inertia = [0.01, 0.3, 0.3]
start.pose = {{ origin = [{:.17g}, {:.17g}, 0] }}
[run]
until = 0.02
samples = 10
)toml",
                                 arm * std::cos(turn), arm * std::sin(turn));
  for (int k = 0; k < count; ++k) {
    const char* kept = k == 0 ? "keep" : "guess";
    text += fmt::format(R"toml([[body]]
name = "crank{0}"
mass = 1
center_of_mass = [{2:.17g}, 0, 0]
inertia = [1e-3, 1e-2, 1e-2]
[[joint]]
name = "A{0}"
type = "revolute"
parent = {{ body = "ground", point = [{3:.17g}, 0, 0] }}
child = "crank{0}"
start.turn_z = {{ {4} = {1:.17g}{5} }}
[[joint]]
name = "B{0}"
type = "revolute"
parent = {{ body = "crank{0}", point = [{6:.17g}, 0, 0] }}
child = {{ body = "coupler", point = [{3:.17g}, 0, 0] }}
start.turn_z = {{ guess = {7:.17g} }}
)toml",
                        k, turn, arm / 2, k * 0.33, kept, k == 0 ? ", keep_speed = 1" : "", arm, -turn);
  }
  return parse_model(text, "cranks.toml");
}

TEST_CASE("A coupler on equal cranks moves in poses from which others are flat", "[closure]") {
  // Every pose is a parallelogram; a search for a general one that ends in the flat pose must not take it for one.
  const double turn = GENERATE(0.4, 0.9272952180016123, 1.3, 2.2);
  const double arm = GENERATE(0.25, 0.31);
  CAPTURE(turn, arm);
  expect_to_agree(equal_cranks(4, turn, arm), {});
}

TEST_CASE("A coupler on equal cranks moves near the flat pose, too", "[closure]") {
  const int count = GENERATE(3, 4, 6);
  const double turn = GENERATE(0.01, 0.05, 0.17);
  CAPTURE(count, turn);
  expect_to_agree(equal_cranks(count, turn, 0.31), {});
}

TEST_CASE("A platform on three equal cranks moves, however large the machine is that it is a part of", "[closure]") {
  // Put together otherwise, the three cranks hold the platform: such a pose, far from the start, tells nothing of it.
  const int tilt = GENERATE(15, 25, 35);
  const double far = GENERATE(7.0, 30.0, 45.0);
  std::string text = fmt::format(R"toml(format = 1
gravity = [0, 0.5, -9.81]
[parameters]
tilt = "{} deg"
[[body]]
name = "platform"
mass = 2.5
center_of_mass = [0.4, 0.05, 0.02]
inertia = [0.1, 0.12, 0.2]
[run]
until = 0.02
samples = 10
)toml",
                                 tilt);
  constexpr std::array<std::array<double, 2>, 3> kFeet{{{0.0, 0.0}, {0.5, -0.1}, {1.1, 0.2}}};
  for (int k = 0; k < 3; ++k) {
    const auto& [x, y] = kFeet[k];
    text += fmt::format(R"toml([[body]]
name = "crank{0}"
mass = 0.8
center_of_mass = [0.25, 0, 0]
inertia = [0.001, 0.02, 0.02]
[[joint]]
name = "A{0}"
type = "revolute"
parent = {{ body = "ground", point = ["2 + {1}*cos(tilt)", {2}, "-{1}*sin(tilt)"], axis = [0, 1, 0], angle = "tilt" }}
child = "crank{0}"
start.turn_z = {{ {3} }}
[[joint]]
name = "B{0}"
type = "revolute"
parent = {{ body = "crank{0}", point = [0.5, 0, 0] }}
child = {{ body = "platform", point = [{1}, {2}, 0] }}
start.turn_z = {{ guess = -0.9 }}
)toml",
                        k, x, y, k == 0 ? "keep = 0.9, keep_speed = 0" : "guess = 0.9");
  }
  text += fmt::format(R"toml([[body]]
name = "pendulum"
mass = 1
center_of_mass = [0, 0, -0.3]
inertia = [0.03, 0.03, 0.001]
[[joint]]
name = "far"
type = "revolute"
both = {{ z = [0, 1, 0], x = [1, 0, 0] }}
parent = {{ body = "ground", point = [{:g}, 0, 0] }}
child = "pendulum"
start.turn_z = {{ keep = 0.1, keep_speed = 0 }}
)toml",
                      far);
  CAPTURE(tilt, far);
  expect_to_agree(parse_model(text, "platform.toml"), {});
}

/// Two bars, the second one's frame turned in it, over a span of their whole length; `beside` is what else there is.
Model stretched_triangle(double longer, double shorter, double turn, const std::string& beside) {
  return parse_model(
      fmt::format(R"toml(format = 1
gravity = [0.3, -9.7, 0.2]
[[body]]
name = "long"
mass = 0.6
center_of_mass = [0.1, 0.01, 0]
inertia = [0.003, 0.005, 0.006]
[[body]]
name = "short"
mass = 0.9
center_of_mass = [0.03, -0.01, 0.02]
inertia = [0.008, 0.009, 0.009]
[[joint]]
name = "A"
type = "revolute"
parent = "ground"
child = "long"
start.turn_z = {{ guess = 0, guess_speed = 0 }}
[[joint]]
name = "B"
type = "revolute"
parent = {{ body = "long", point = [{0:.17g}, 0, 0] }}
child = "short"
start.turn_z = {{ guess = {1:.17g}, keep_speed = 0 }}
[[joint]]
name = "C"
type = "revolute"
parent = {{ body = "ground", point = [{2:.17g}, 0, 0] }}
child = {{ body = "short", point = [{3:.17g}, {4:.17g}, 0], axis = [0, 0, 1], angle = {5:.17g} }}
start.turn_z = {{ keep = 0, guess_speed = 0 }}
[run]
until = 0.05
)toml",
                  longer, turn, longer + shorter, shorter * std::cos(turn), -shorter * std::sin(turn), -turn) +
          beside,
      "stretched.toml");
}

TEST_CASE("A triangle of bars that is stretched flat is refused as singular: no other pose of it is near",
          "[closure]") {
  // It can move infinitely little and no further: all poses that close nearby are this one, and round-off decides in
  // which of them rows are independent.
  const double longer = GENERATE(0.23, 0.37, 0.5);
  const double shorter = GENERATE(0.02, 0.04);
  const double turn = GENERATE(0.0, 0.2617993877991494, 0.6981317007977318);
  const std::string beside = GENERATE("", R"toml([[body]]
name = "pendulum"
mass = 1
center_of_mass = [0.2, 0, 0]
inertia = [0.001, 0.01, 0.01]
[[joint]]
name = "D"
type = "revolute"
parent = { body = "ground", point = [0, 1, 0] }
child = "pendulum"
start.turn_z = { keep = 0.3, keep_speed = 1 }
)toml");
  CAPTURE(longer, shorter, turn, beside);
  const Model model = stretched_triangle(longer, shorter, turn, beside);
  for (const auto& make : {cartesian::make_solver, relative::make_solver}) {
    const auto solver = make(model);
    INFO(solver->name());
    CHECK_THROWS_WITH(solver->integrate({0.05, 1e-11, 10, ""}, {}), Catch::Contains("at t = 0 s"));
  }
}

TEST_CASE("Shafts joined by Hooke's joint start from rest though a row of their loop vanishes in that pose",
          "[closure]") {
  expect_to_agree(machine_of("loops", "hooke_from_rest"), {});
}

TEST_CASE("A loop stays closed where round-off of places is a thousand times as much of a turn that it ties",
          "[closure]") {
  expect_to_agree(machine_of("loops", "belt_near_an_axis"), {});
}

}  // namespace
}  // namespace concord::verification
