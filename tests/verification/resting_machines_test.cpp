#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>

#include "closed_forms.h"
#include "compare/equilibrium/started_machine.h"
#include "judged_machines.h"

/// Machines without gravity that come to rest: what is left of their speeds is round-off, and no speed of theirs says
/// so.
namespace concord::verification {
namespace {

std::string bar(const std::string& name, double length, double mass) {
  return fmt::format(R"([[body]]
name = "{}"
mass = {}
center_of_mass = [{}, 0.01, -0.02]
inertia = [{}, {}, {}]
)",
                     name, mass, 0.45 * length, 0.002 * mass, 0.09 * mass * length * length,
                     0.091 * mass * length * length);
}

/// A four-bar whose crank is turned from rest to rest.
Model stopping_four_bar(const std::string& law) {
  return parse("format = 1\n" + bar("crank", 0.12, 0.8) + bar("coupler", 0.33, 0.5) + bar("rocker", 0.26, 1.1) +
               R"([[joint]]
name = "A"
type = "revolute"
parent = { body = "ground", point = [0.02, -0.01, 0.03] }
child = "crank"
drive.turn_z = )" +
               law + R"(
[[joint]]
name = "B"
type = "revolute"
parent = { body = "crank", point = [0.12, 0, 0] }
child = "coupler"
start.turn_z = { guess = "-25 deg" }
[[joint]]
name = "C"
type = "spherical"
parent = { body = "coupler", point = [0.33, 0, 0] }
child = { body = "rocker", point = [0.26, 0, 0] }
[[joint]]
name = "D"
type = "revolute"
parent = { body = "ground", point = [0.34, -0.05, 0.03] }
child = "rocker"
start.turn_z = { guess = "75 deg" }
[run]
until = 0.5
)");
}

/// A chain of two arms and a slide, driven and at rest again before the run ends.
Model stopping_chain() {
  return parse("format = 1\n" + bar("one", 0.4, 2.0) + bar("two", 0.3, 1.5) + bar("three", 0.2, 0.7) + R"([[joint]]
name = "waist"
type = "revolute"
parent = { body = "ground", axis = [0.3, 1, 0.2], angle = "50 deg" }
child = "one"
drive.turn_z = { law = "smooth_step", t0 = 0.05, t1 = 0.27, from = 0.3, to = -0.6 }
[[joint]]
name = "arm"
type = "revolute"
parent = { body = "one", point = [0.4, 0, 0], axis = [1, 0.2, 0], angle = "70 deg" }
child = "two"
drive.turn_z = { law = "smooth_step", t0 = 0.0, t1 = 0.3, from = 0, to = 0.9 }
[[joint]]
name = "slide"
type = "translational"
parent = { body = "two", point = [0.3, 0, 0], axis = [0, 1, 0.3], angle = "40 deg" }
child = "three"
drive.slide_z = { law = "smooth_step", t0 = 0.02, t1 = 0.29, from = 0, to = 0.15 }
[run]
until = 0.4
)");
}

/// A blade that rings on after its hub has stopped.
Model stopping_blade() {
  return parse(R"(format = 1
[[body]]
name = "blade"
[body.beam]
first_end = [0.04, 0, 0]
length = 0.55
elements = 8
section = { width_y = 0.02, width_z = 0.005 }
youngs_modulus = 7.0e10
poissons_ratio = 0.33
density = 2700
support = "cantilever"
modes = { bending_xz = [1], bending_xy = [1], torsion = [1] }
damping_ratio = 0.05
[[joint]]
name = "hub"
type = "revolute"
parent = { body = "ground", x = [1, 0, 0], z = [0, -1, 0.7] }
child = { body = "blade", node = "first", offset = [-0.04, 0, 0] }
drive.turn_z = { law = "smooth_step", t0 = 0.03, t1 = 0.2, from = 0, to = 0.8 }
[run]
until = 0.3
)");
}

/// A body on a preloaded spring and one on a tire, metres above the origin, that stand where nothing moves them.
Model standing_machine() {
  return parse(R"(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "block"
mass = 1.4
inertia = [0.011, 0.012, 0.013]
center_of_mass = [0, 0, 0.03]
[[body]]
name = "wheel"
mass = 17.0
inertia = [0.5, 0.9, 0.5]
[[road]]
name = "road"
profile = "flat"
[[joint]]
name = "guide"
type = "translational"
parent = { body = "ground", point = [0.2, -0.1, 3.1] }
child = "block"
spring.slide_z = { stiffness = 870.0, damping = 0.0 }
start.slide_z = { keep = 0.0, keep_speed = 0.0 }
[[joint]]
name = "lift"
type = "translational"
parent = { body = "ground", point = [1, 0.3, 0] }
child = "wheel"
start.slide_z = { keep = 0.2990, keep_speed = 0.0 }
[[tire]]
name = "tire"
body = "wheel"
road = "road"
radius = 0.3
stiffness = 152000.0
damping = 90.0
slip_stiffness = 31000.0
cornering_stiffness = 21000.0
friction = 0.9
[run]
until = 1.0
start = "equilibrium"
)");
}

}  // namespace

// Detects round-off of places, which a body that stands gathers while its forces go on working at a speed near zero.
TEST_CASE("A machine that stands in equilibrium high above the origin keeps its energy") {
  const Model model = standing_machine();
  compare::VerifyOptions options;
  options.states = 40;
  expect_to_agree(model, options);
}

// Detects an energy that is held against what joints pass on, which is nothing where they balance their own springs.
TEST_CASE("A skate that rests between its own springs keeps its energy") {
  const Model model = parse(R"(format = 1
[[body]]
name = "skate"
mass = 1.1
center_of_mass = [0.05, 0, 0]
inertia = [0.011, 0.012, 0.013]
[[joint]]
name = "edge"
type = "knife_edge"
parent = "ground"
child = "skate"
start.slide_x = { keep = 0.3, keep_speed = 0 }
start.slide_y = { keep = 0.2 }
start.turn_z = { keep = 0.7, keep_speed = 0 }
spring.slide_x = { stiffness = 43 }
spring.slide_y = { stiffness = 31 }
spring.turn_z = { stiffness = 0.6 }
[run]
until = 0.5
start = "equilibrium"
)");
  compare::VerifyOptions options;
  options.states = 40;
  std::string note;
  expect_to_agree(compare::as_it_starts(model, kMakers, note), options);
}

// Detects a spring that is refused where its ends meet though its force vanishes there.
TEST_CASE("A spring of no free length acts where its ends meet at the start") {
  const std::string thrown = R"(format = 1
gravity = [0, 0, 0]
[[body]]
name = "ball"
mass = 1.3
inertia = [0.01, 0.012, 0.013]
[[joint]]
name = "free"
type = "free"
parent = { body = "ground", point = [0.1, 0.7, -0.4], axis = [1, 2, 0.5], angle = 0.7 }
child = "ball"
start.slide_x = { keep = 0.0, keep_speed = SPEED }
start.slide_y = { keep = 0.0, keep_speed = 0.0 }
start.slide_z = { keep = 0.0, keep_speed = 0.0 }
start.ball = { keep = { axis = [0, 0, 1], angle = 0.0 }, keep_speed = [0, 0, 0] }
[[line_spring]]
name = "cord"
parent = { body = "ground", point = [0.1, 0.7, -0.4] }
child = "ball"
stiffness = 210.0
damping = 3.0
free = 0.0
[run]
until = 0.3
)";
  for (const double speed : {0.0, 1.7}) {
    std::string text = thrown;
    const Model model = parse(text.replace(text.find("SPEED"), 5, fmt::format("{}", speed)));
    const auto solvers = {cartesian::make_solver(model), relative::make_solver(model)};
    for (const auto& solver : solvers) {
      const Evaluation now = solver->evaluate(solver->assemble());
      const Vec3 force = now.elements[0].on_side(Side::child).in_global.force;
      CHECK(force.norm() == Approx(3.0 * speed).margin(1e-12));
      const Mat3& C = model.joints[0].on(Side::parent).C;
      CHECK((force + 3.0 * speed * C.col(0)).norm() < 1e-12);
    }
  }
}

// Detects solvers and audit that take a short line for none in different places: ends 3e-11 m apart pass each other.
TEST_CASE("A damper whose ends nearly meet acts along the line between them") {
  const Model model = parse(R"(format = 1
[[body]]
name = "ball"
mass = 1.3
inertia = [0.01, 0.012, 0.013]
[[joint]]
name = "rail"
type = "translational"
parent = { body = "ground", axis = [1, 2, 0.5], angle = 0.7 }
child = "ball"
start.slide_z = { keep = 0.0, keep_speed = 0.3 }
[[line_spring]]
name = "cord"
parent = { body = "ground", axis = [1, 2, 0.5], angle = 0.7, point = [3e-11, 0, 0] }
child = "ball"
stiffness = 210.0
damping = 3.0
free = 0.0
[run]
until = 0.1
)");
  compare::VerifyOptions options;
  options.states = 40;
  expect_to_agree(model, options);
}

// Detects speeds that are compared with a largest speed that is round-off itself.
TEST_CASE("A machine that its driver brings to rest without gravity agrees") {
  SECTION("a loop, before the run ends") {
    const Model model =
        stopping_four_bar(R"({ law = "smooth_step", t0 = 0.1, t1 = 0.4, from = "35 deg", to = "95 deg" })");
    expect_to_agree(model, in_short(model, 1.0));
  }
  SECTION("a loop, as the run ends") {
    const Model model =
        stopping_four_bar(R"({ law = "smooth_step", t0 = 0.0, t1 = 0.5, from = "35 deg", to = "60 deg" })");
    expect_to_agree(model, in_short(model, 1.0));
  }
  SECTION("a tree") {
    const Model model = stopping_chain();
    expect_to_agree(model, in_short(model, 1.0));
  }
  SECTION("a flexible body") {
    const Model model = stopping_blade();
    expect_to_agree(model, in_short(model, 1.0));
  }
}

/// What must pass through each gear, by hand: 6 N m and 6 * 2.4; 7; and the spring's 11 * 0.37 / 1.9 over 1.9.
TEST_CASE("Torques that gears hold or pass on are judged though no bearing carries anything", "[resting]") {
  const std::vector<std::pair<std::string, std::vector<double>>> gears{
      {"gear_that_holds", {7.0}},
      {"motor_against_brake", {6.0, 6.0 * 2.4}},
      {"motor_that_stands", {11.0 * 0.37 / 1.9 / 1.9}}};
  for (const auto& [name, forces] : gears) {
    INFO(name);
    const Model model = machine_of("gears", name);
    expect_to_agree(model, {});
    for (const auto& make : {cartesian::make_solver, relative::make_solver}) {
      const auto solver = make(model);
      const Evaluation start = solver->evaluate(solver->assemble());
      for (std::size_t k = 0; k < forces.size(); ++k) {
        CHECK(std::abs(start.couplings[k]) == Approx(forces[k]).epsilon(1e-12));
      }
    }
  }
}

TEST_CASE("A structure at rest closes to itself: no closing of it is said to find another state", "[resting]") {
  const Model model = parse(R"(format = 1
gravity = [0.3, 0.2, -9.7]
[[body]]
name = "bracket"
mass = 2.3
center_of_mass = [0.2, 0.03, 0.01]
inertia = [0.01, 0.02, 0.025]
[[joint]]
name = "foot"
type = "weld"
parent = { body = "ground", point = [0.1, 0.2, 0.3], axis = [1, 2, 0.5], angle = "35 deg" }
child = { body = "bracket", point = [0, 0.123, 0] }
[run]
until = 0.5
)");
  const compare::Verdict verdict = judged(model, in_short(model, 1.0));
  CHECK(verdict.outcome == compare::Outcome::agree);
  CHECK(verdict.notes.empty());
}

TEST_CASE("A strut or shaft whose modes feel next to nothing of what it carries agrees, and its resolution is known",
          "[resting]") {
  for (const std::string& name : machines_of("struts")) {
    INFO(name);
    const Model model = machine_of("struts", name);
    const compare::Verdict verdict = judged(model, in_short(model, 1.0));
    INFO(compare::format_verdict(model, verdict, false));
    CHECK(verdict.outcome == compare::Outcome::agree);
    for (const std::string& note : verdict.notes) CHECK(note.find("resolution unknown") == std::string::npos);
  }
}

}  // namespace concord::verification
