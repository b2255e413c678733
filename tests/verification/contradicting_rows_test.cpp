#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "closed_forms.h"
#include "compare/equilibrium/started_machine.h"
#include "judged_machines.h"

/// Poses in which constraints depend on each other by accident, and ask for accelerations that contradict each other.
namespace concord::verification {
namespace {

/// A triangle of two bars and ground, stretched: its driver turns the first bar although nothing can move farther.
Model stretched_triangle(double speed) {
  return parse_model(R"(format = 1
name = "stretched_triangle"
gravity = [0.0, -9.81, 0.0]

[[body]]
name = "first"
mass = 0.7
inertia = [0.01, 0.02, 0.03]

[[body]]
name = "second"
mass = 0.4
inertia = [0.02, 0.01, 0.025]

[[joint]]
name = "drive"
type = "revolute"
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "first", point = [0.0, 0.0, 0.0] }
drive.turn_z = { law = "polynomial", coefficients = [0.0, )" +
                         std::to_string(speed) + R"(] }

[[joint]]
name = "middle"
type = "revolute"
parent = { body = "first", point = [0.3, 0.0, 0.0] }
child = { body = "second", point = [0.0, 0.0, 0.0] }
start.turn_z = { guess = 0.0, guess_speed = )" +
                         std::to_string(-2.5 * speed) + R"( }

[[joint]]
name = "end"
type = "revolute"
cut = true
parent = { body = "ground", point = [0.5, 0.0, 0.0] }
child = { body = "second", point = [0.2, 0.0, 0.0] }
start.turn_z = { guess = 0.0, guess_speed = )" +
                         std::to_string(-1.5 * speed) + R"( }

[run]
until = 0.1
)",
                     "stretched_triangle.toml");
}

/// A triangle of two bars and ground that lies on one line and is locked there; a load sets its bars against each
/// other.
Model locked_triangle(double first, double second, double ground) {
  constexpr std::string_view text = R"(format = 1
name = "locked_triangle"
gravity = [1.0, -9.81, 0.5]

[[body]]
name = "first"
mass = 0.7
inertia = [0.01, 0.02, 0.03]

[[body]]
name = "second"
mass = 0.4
inertia = [0.02, 0.01, 0.025]

[[joint]]
name = "foot"
type = "revolute"
parent = {{ body = "first" }}
child = {{ body = "ground", point = [0.1, 0.25, 0.0] }}
start.turn_z = {{ keep = 0.0, guess_speed = 0.0 }}

[[joint]]
name = "middle"
type = "revolute"
parent = {{ body = "first", point = [{}, 0.0, 0.0] }}
child = {{ body = "second", point = [0.0, -0.15, 0.0] }}
start.turn_z = {{ guess = 0.0, keep_speed = 0.0 }}

[[joint]]
name = "end"
type = "revolute"
parent = {{ body = "ground", point = [{}, 0.25, 0.0] }}
child = {{ body = "second", point = [{}, -0.15, 0.0] }}
start.turn_z = {{ guess = 0.0, guess_speed = 0.0 }}

[[turn_spring]]
name = "preload"
parent = {{ body = "first", point = [0.1, 0.02, 0.0] }}
child = {{ body = "second", point = [-0.05, 0.1, 0.0], euler_parameters = [0.8, 0.2, 0.4, 0.4] }}
preload = 0.31

[run]
until = 0.04
)";
  return parse_model(fmt::format(text, first, 0.1 + ground, second), "locked_triangle.toml");
}

/// A tilted four-bar of hinges, one of whose axes has lost its last digits.
Model rounded_four_bar() {
  const auto bar = [](const std::string& name, double length) {
    return fmt::format(R"([[body]]
name = "{}"
mass = 0.9
center_of_mass = [0.01, {}, {}]
inertia = [0.002, 0.005, 0.0055]
)",
                       name, 0.4 * length, 0.3 * length);
  };
  const auto at = [](double along, const std::string& z = "[1, 2, -2]") {
    return fmt::format("point = [0, {0}, {0}], x = [0, 1, 1], z = {1}", along, z);
  };
  const auto hinge = [](const std::string& name, const std::string& parent, const std::string& child) {
    return fmt::format(R"([[joint]]
name = "{}"
type = "revolute"
parent = {{ body = {} }}
child = {{ body = {} }}
start.turn_z = {{ {} }}
)",
                       name, parent, child, name == "A" ? "keep = 0.0, keep_speed = 3" : "guess = 1.0");
  };
  return parse("format = 1\ngravity = [0.3, -9.8, 0.5]\n" + bar("crank", 0.14) + bar("coupler", 0.42) +
               bar("rocker", 0.28) + hinge("A", "\"ground\", " + at(0.0), "\"crank\", " + at(0.0)) +
               hinge("B", "\"crank\", " + at(0.07), "\"coupler\", " + at(0.0, "[1.000003, 2, -2]")) +
               hinge("C", "\"coupler\", " + at(0.21), "\"rocker\", " + at(0.14)) +
               hinge("D", "\"ground\", " + at(0.21), "\"rocker\", " + at(0.0)));
}

}  // namespace

TEST_CASE("Beside the singular pose in which a loop is locked no state is judged, and no difference is told",
          "[quick][singular]") {
  for (const auto& [first, second] : {std::pair{-0.3, 0.7}, std::pair{0.45, 0.2}, std::pair{-0.17, 1.1}}) {
    const Model model = locked_triangle(first, second, first + second);
    INFO(first << " and " << second);
    compare::VerifyOptions options;
    options.states = 24;
    options.samples = 23;
    options.refines = false;
    const compare::Verdict verdict = judged(model, options);
    INFO(compare::format_verdict(model, verdict, false));
    CHECK(verdict.findings.empty());
    CHECK(verdict.outcome == compare::Outcome::failed);
    CHECK(verdict.singular_states > 0);
  }
}

TEST_CASE("No solver gives numbers where dependent constraints contradict each other", "[quick][singular]") {
  const Model model = stretched_triangle(1.7);
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    const State start = solver->assemble();
    CHECK_THROWS_AS(solver->evaluate(start), SingularPose);
  }
}

TEST_CASE("Redundant constraints that agree are no contradiction, moving or at rest", "[quick][singular]") {
  const Model door = parse_model(R"(format = 1
name = "door"
gravity = [0.4, -9.81, 0.2]

[[body]]
name = "door"
mass = 11.0
center_of_mass = [0.4, 0.02, 0.9]
inertia = [3.0, 4.0, 1.3, 0.1, -0.2, 0.3]

[[joint]]
name = "lower_hinge"
type = "revolute"
parent = { body = "ground", point = [0.1, 0.0, 0.2] }
child = { body = "door", point = [0.0, 0.0, 0.2] }
start.turn_z = { keep = 0.3, keep_speed = 2.2 }

[[joint]]
name = "upper_hinge"
type = "revolute"
cut = true
parent = { body = "ground", point = [0.1, 0.0, 1.7] }
child = { body = "door", point = [0.0, 0.0, 1.7] }

[run]
until = 0.1
)",
                                 "door.toml");
  for (const auto& solver : both_solvers(door)) {
    INFO(solver->name());
    State state = solver->assemble();
    CHECK_NOTHROW(solver->evaluate(state));
    for (BodyState& body : state.bodies) {
      body.v.setZero();
      body.omega.setZero();
    }
    CHECK_NOTHROW(solver->evaluate(state));
  }
}

TEST_CASE("A loop of hinges that one rounded axis locks is refused with the angle that it is off", "[quick]") {
  CHECK_THROWS_WITH(compare::StartedMachine(rounded_four_bar(), kMakers),
                    Catch::Contains("e-07 rad about (") && Catch::Contains("of its frame on the parent"));
}

}  // namespace concord::verification
