#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "compare/analyses/linearize.h"
#include "compare/equilibrium/equilibrium.h"

/// Soft motions beside stiff ones, motions without stiffness beside both, and chains of many links.
namespace concord::verification {
namespace {

using compare::Equilibrium;
using compare::find_equilibrium;
using compare::held_at_start;
using compare::analyses::Linearization;
using compare::analyses::linearize;

/// A rod on a hinge in a light block on a bushing; y is the hinge's axis, the rod hangs where its angle is -pi/2.
std::string rod_on_a_light_block(double stiffness) {
  return fmt::format(R"toml(format = 1
gravity = [0, 0, -9.7]
[[body]]
name = "block"
mass = 0.03
inertia = [4e-6, 5e-6, 3e-6]
[[joint]]
name = "place"
type = "free"
parent = "ground"
child = "block"
start.ball = {{ keep = {{ axis = [0, 0, 1], angle = 0 }}, keep_speed = [0, 0, 0] }}
start.slide_x = {{ keep = 0, keep_speed = 0 }}
start.slide_y = {{ keep = 0, keep_speed = 0 }}
start.slide_z = {{ keep = 0, keep_speed = 0 }}
[[bushing]]
name = "mount"
parent = "ground"
child = "block"
stiffness = [{0}, {0}, {0}, {1}, {1}, {1}]
[[body]]
name = "rod"
mass = 40.0
inertia = [2.0, 310.0, 310.0]
center_of_mass = [4.0, 0, 0]
[[joint]]
name = "hinge"
type = "revolute"
parent = {{ body = "block", axis = [1, 0, 0], angle = "90 deg" }}
child = {{ body = "rod", axis = [1, 0, 0], angle = "90 deg" }}
start.turn_z = {{ keep = -1.2, keep_speed = 0 }}
)toml",
                     stiffness, 1e-3 * stiffness);
}

TEST_CASE("A heavy rod on a light block's stiff mount hangs and swings as on a hinge fixed to ground",
          "[analyses][quick]") {
  const double stiffness = GENERATE(2e8, 3e9);
  const Model model = held_at_start(parse(rod_on_a_light_block(stiffness)));
  const double exact = std::sqrt(40.0 * 9.7 * 4.0 / (310.0 + 40.0 * 16.0));
  for (const auto& solver : both_solvers(model)) {
    const Equilibrium found = find_equilibrium(model, *solver);
    CHECK(found.free.empty());
    CHECK(found.unstable == 0);
    CHECK(found.state.q[1](0) == Approx(-0.5 * EIGEN_PI).margin(1e-6));
    const Linearization about = linearize(model, *solver, found.state);
    REQUIRE(about.modes.size() == 7);
    CHECK_FALSE(about.modes[0].is_free);
    CHECK(about.modes[0].eigenvalue.imag() == Approx(exact).epsilon(1e-4));
  }
}

/// Bodies on rails along z, each on a spring to ground; without stiffness none. A rotor beside them turns freely.
std::string springs_beside_each_other(const std::vector<double>& stiffnesses) {
  std::string text = "format = 1\ngravity = [0, -9.7, 0]\n";
  for (std::size_t k = 0; k < stiffnesses.size(); ++k) {
    text += fmt::format(R"toml([[body]]
name = "mass{0}"
mass = 2.0
inertia = [0.1, 0.1, 0.1]
[[joint]]
name = "rail{0}"
type = "translational"
parent = {{ body = "ground", point = [{0}, 0.3, 0] }}
child = "mass{0}"
start.slide_z = {{ keep = 0.1, keep_speed = 0 }}
spring.slide_z = {{ stiffness = {1}, free = 0.1 }}
)toml",
                        k, stiffnesses[k]);
  }
  return text + R"toml([[body]]
name = "rotor"
mass = 2.0
inertia = [0.1, 0.1, 0.1]
[[joint]]
name = "bearing"
type = "revolute"
parent = { body = "ground", point = [0.7, 1.0, 0] }
child = "rotor"
start.turn_z = { keep = 0.4, keep_speed = 0 }
)toml";
}

TEST_CASE("A weight finds its rest on the first part of a stop's way, however short, and swings there as its law says",
          "[analyses][quick]") {
  const double width = GENERATE(1e-3, 1e-6, 2e-8);
  constexpr double kMass = 1.7;
  constexpr double kGravity = 9.81;
  constexpr double kPart = 0.22;  // of the width, that the weight presses the stop in
  const double soft = std::pow(kPart, 3) - 0.5 * std::pow(kPart, 4);
  const double stiffness = kMass * kGravity / (width * soft);
  const Model model = held_at_start(parse(fmt::format(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "weight"
mass = 1.7
inertia = [0.5, 0.7, 0.6]
[[joint]]
name = "guide"
type = "translational"
parent = "ground"
child = "weight"
start.slide_z = {{ keep = 0, keep_speed = 0 }}
spring.slide_z = {{ lower_stop = {{ at = -1.0, stiffness = {}, width = {} }} }}
)toml",
                                                      stiffness, width)));
  const double exact = std::sqrt(stiffness * (3.0 * kPart * kPart - 2.0 * std::pow(kPart, 3)) / kMass);
  for (const auto& solver : both_solvers(model)) {
    const Equilibrium found = find_equilibrium(model, *solver);
    CHECK(found.free.empty());
    CHECK(-1.0 - found.state.q[0](0) == Approx(kPart * width).epsilon(1e-6));
    const Linearization about = linearize(model, *solver, found.state);
    REQUIRE(about.modes.size() == 1);
    CHECK(about.modes[0].eigenvalue.imag() == Approx(exact).epsilon(1e-5));
  }
}

TEST_CASE("Springs that differ by fourteen orders keep their frequencies, and a free rotor beside them is free",
          "[analyses][quick]") {
  const std::vector<double> stiffnesses{3e-3, 0.7, 500.0, 8e10};
  const Model model = held_at_start(parse(springs_beside_each_other(stiffnesses)));
  for (const auto& solver : both_solvers(model)) {
    const Linearization found = linearize(model, *solver, solver->assemble());
    REQUIRE(found.modes.size() == 6);
    for (int k = 0; k < 2; ++k) {
      CHECK(found.modes[k].is_free);
      CHECK(found.modes[k].eigenvalue == 0.0);
      CHECK(found.modes[k].motion == "turn_z of bearing");
    }
    for (int k = 0; k < 4; ++k) {
      const double exact = std::sqrt(stiffnesses[k] / 2.0);
      CHECK_FALSE(found.modes[2 + k].is_free);
      CHECK(found.modes[2 + k].eigenvalue.imag() == Approx(exact).epsilon(1e-6));
    }
    CHECK(find_equilibrium(model, *solver).free.size() == 1);
  }
}

/// Links of 0.13 m on each other, the first one on ground; y is up.
std::string chain_of(int links) {
  std::string text = "format = 1\ngravity = [0, -9.7, 0]\n";
  for (int k = 0; k < links; ++k) {
    text += fmt::format(R"toml([[body]]
name = "link{0}"
mass = 0.4
inertia = [2e-6, 6e-4, 6e-4]
center_of_mass = [0.065, 0, 0]
[[joint]]
name = "hinge{0}"
type = "revolute"
parent = {{ body = "{1}", point = [{2}, 0, 0] }}
child = "link{0}"
start.turn_z = {{ keep = {3}, keep_speed = 0 }}
)toml",
                        k, k == 0 ? "ground" : fmt::format("link{}", k - 1), k == 0 ? 0.0 : 0.13, k == 0 ? -0.4 : 0.03);
  }
  return text;
}

TEST_CASE("A chain of twenty links is found hanging in less than a minute", "[analyses][quick]") {
  constexpr int kLinks = 20;
  const Model model = held_at_start(parse(chain_of(kLinks)));
  for (const auto& solver : both_solvers(model)) {
    const Equilibrium found = find_equilibrium(model, *solver);
    CHECK(found.unstable == 0);
    CHECK(found.free.empty());
    CHECK(found.iterations < 80);
    for (int k = 0; k < kLinks; ++k) {
      CHECK(found.state.q[k](0) == Approx(k == 0 ? -0.5 * EIGEN_PI : 0.0).margin(1e-10));
      const double below = 0.4 * 9.7 * (kLinks - k);
      CHECK(found.evaluation.joints[k].reaction_on(Side::child).in_global.force.y() == Approx(below).epsilon(1e-10));
    }
  }
}

}  // namespace
}  // namespace concord::verification
