#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "closed_forms.h"
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

}  // namespace concord::verification
