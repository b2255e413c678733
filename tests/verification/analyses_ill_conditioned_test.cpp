#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "closed_forms.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/report.h"
#include "judged_machines.h"

/// Analyses and short runs where double precision, or the statement itself, leaves less than usual.
namespace concord::verification {
namespace {

using compare::Outcome;
using compare::analyses::AnalysisVerdict;
using compare::analyses::format_analysis;
using compare::analyses::judge_inverse;
using compare::analyses::judge_linearization;
using compare::analyses::judge_statics;

/// A body of 2 kg on a vertical slide with these lines for its joint.
Model body_on_slide(const std::string& joint, double inertia) {
  return parse(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "m"
mass = 2
inertia = [)toml" +
               fmt::format("{0}, {0}, {0}", inertia) + R"toml(]
[[joint]]
name = "s"
type = "translational"
parent = "ground"
child = "m"
)toml" + joint);
}

double height_of(const AnalysisVerdict& found) {
  return found.wrenches.trajectories[1]->samples[0].state.bodies[1].r.z();
}

TEST_CASE("Modes agree as far as differences of accelerations resolve them", "[analyses][quick]") {
  for (const char* name : {"gyroscope_in_gimbals", "nearly_flat"}) {
    const Model model = machine_of("modes", name);
    const AnalysisVerdict found = judge_linearization(model, kMakers, false);
    INFO(format_analysis(model, found, true));
    CHECK(found.wrenches.outcome == Outcome::agree);
    for (const auto& row : found.numbers) {
      if (row.name == "eigenvalue 5") CHECK(row.digits > 8.0);
    }
  }
}

// Detects a resolution that is the largest of too few draws.
TEST_CASE("Modes of a thin rod agree as far as accelerations about its own axis are known", "[analyses][quick]") {
  const Model model = machine_of("modes", "thrown_thin_rod");
  const AnalysisVerdict found = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, found, true));
  CHECK(found.wrenches.outcome == Outcome::agree);
}

TEST_CASE(
    "A rate that one solver's differences do not tell from zero is no difference, and the table says which are not",
    "[analyses][quick]") {
  const Model model = machine_of("modes", "hardly_braked_slides");
  const AnalysisVerdict found = judge_linearization(model, kMakers, false);
  const std::string table = format_analysis(model, found, true);
  INFO(table);
  CHECK(found.wrenches.outcome == Outcome::agree);
  CHECK_THAT(table, Catch::Contains("free: differences of cartesian tell no rate below"));
}

TEST_CASE("A loop near a singular pose agrees as far as its closing is known", "[quick]") {
  const Model model = machine_of("modes", "nearly_flat");
  expect_to_agree(model, in_short(model, 1.0));
}

TEST_CASE("A soft spring is followed to its rest a hundred lengths of the machine away", "[analyses][quick]") {
  for (const double inertia : {1e-2, 1e-9}) {
    const Model model =
        body_on_slide("start.slide_z = { keep = 0, keep_speed = 0 }\nspring.slide_z = { stiffness = 1.5 }\n", inertia);
    const AnalysisVerdict found = judge_statics(model, kMakers);
    INFO(format_analysis(model, found, true));
    CHECK(found.wrenches.outcome == Outcome::agree);
    CHECK(height_of(found) == Approx(-2.0 * 9.81 / 1.5).epsilon(1e-10));
  }
}

TEST_CASE("A body that falls freely onto a stop is found at rest on it", "[analyses][quick]") {
  const Model model = body_on_slide(
      "start.slide_z = { keep = 0.9, keep_speed = 0 }\n"
      "spring.slide_z = { lower_stop = { at = 0.1, stiffness = 4e4, width = 1e-4 } }\n",
      1e-3);
  const AnalysisVerdict found = judge_statics(model, kMakers);
  INFO(format_analysis(model, found, true));
  CHECK(found.wrenches.outcome == Outcome::agree);
  // In full after its width, a stop gives as if it began in the middle of it.
  CHECK(height_of(found) == Approx(0.1 - 0.5e-4 - 2.0 * 9.81 / 4e4).epsilon(1e-9));
}

TEST_CASE("A door is closed by what pushes it, however many turns its stop is away", "[analyses][quick]") {
  for (const double start : {-3.0, -7.0, -30.0}) {
    INFO(start);
    const Model model = parse(fmt::format(R"toml(format = 1
[[body]]
name = "door"
mass = 3
inertia = [0.3, 0.3, 0.3]
[[joint]]
name = "hinge"
type = "revolute"
parent = "ground"
child = {{ body = "door", point = [-0.5, 0, 0] }}
start.turn_z = {{ keep = {}, keep_speed = 0 }}
spring.turn_z = {{ damping = 0.3, preload = -0.4, upper_stop = {{ at = 0.3, stiffness = 300, width = 1e-4 }} }}
)toml",
                                          start));
    const AnalysisVerdict found = judge_statics(model, kMakers);
    INFO(format_analysis(model, found, true));
    CHECK(found.wrenches.outcome == Outcome::agree);
    CHECK(found.wrenches.trajectories[0]->samples[0].state.q[0](0) == Approx(0.3 + 0.5e-4 + 0.4 / 300).epsilon(1e-9));
  }
}

TEST_CASE("Where nothing holds a direction, the equilibrium nearest to the start is found", "[analyses][quick]") {
  // A mast that turns freely about the vertical, and an arm on it that hangs aside and swings it on its way down.
  const Model model = parse(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "mast"
mass = 0.4
center_of_mass = [0.02, 0.01, 0.1]
inertia = [0.003, 0.003, 0.001]
[[body]]
name = "arm"
mass = 0.8
center_of_mass = [0.05, 0.21, 0.02]
inertia = [0.02, 0.004, 0.019, 0.0005, -0.0003, 0.0004]
[[joint]]
name = "yaw"
type = "revolute"
parent = "ground"
child = "mast"
start.turn_z = { keep = 0.7, keep_speed = 0 }
[[joint]]
name = "shoulder"
type = "revolute"
parent = { body = "mast", point = [0.03, 0, 0.3], z = [1, 0.2, 0.1], x = [0, 1, -2] }
child = { body = "arm", z = [1, 0.3, -0.2], x = [0.3, -1, 0] }
start.turn_z = { keep = 1.9, keep_speed = 0 }
)toml");
  const AnalysisVerdict found = judge_statics(model, kMakers);
  INFO(format_analysis(model, found, true));
  CHECK(found.wrenches.outcome == Outcome::agree);
  for (const auto& row : found.numbers) {
    if (row.name == "turn_z of yaw") CHECK(row.values[0] == Approx(0.7).margin(1e-9));
  }
}

TEST_CASE("Shares of a reaction that balance does not determine are marked, and no verdict stands on them",
          "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "bar"
mass = 3
center_of_mass = [0.4, 0, 0]
inertia = [0.02, 0.2, 0.2]
[[joint]]
name = "left"
type = "revolute"
parent = "ground"
child = "bar"
[[joint]]
name = "right"
type = "revolute"
parent = { body = "ground", point = [0, 0, 1] }
child = { body = "bar", point = [0, 0, 1] }
drive.turn_z = { law = "constant_speed", speed = 0 }
)toml");
  const AnalysisVerdict found = judge_statics(model, kMakers);
  const std::string text = format_analysis(model, found, true);
  INFO(text);
  CHECK(text.find("* not unique: another share") != std::string::npos);
  CHECK(text.find("not unique, not judged: joint left on bar:") != std::string::npos);
}

TEST_CASE("The force of a motor is what it must exert, without what a coupling exerts beside it", "[analyses][quick]") {
  // A pinion of 60 mm drives a rack against a spring: f r on the motor.
  const Model model = parse(R"toml(format = 1
[[body]]
name = "pinion"
mass = 0.3
inertia = [0.001, 0.001, 0.0007]
[[body]]
name = "rack"
mass = 1.1
inertia = [0.001, 0.01, 0.01]
[[joint]]
name = "motor"
type = "revolute"
parent = { body = "ground", point = [0.1, 0.2, 0.3] }
child = "pinion"
start.turn_z = { keep = 0.5, keep_speed = 0 }
[[joint]]
name = "guide"
type = "translational"
parent = { body = "ground", z = [1, 0, 0], x = [0, 0, 1] }
child = { body = "rack", z = [1, 0, 0], x = [0, 0, 1] }
spring.slide_z = { stiffness = 420, free = 0.08 }
[[coupling]]
name = "teeth"
terms = [{ joint = "motor", coordinate = "turn_z", factor = 0.06 },
         { joint = "guide", coordinate = "slide_z", factor = -1 }]
)toml");
  const AnalysisVerdict found = judge_inverse(model, kMakers, {});
  INFO(format_analysis(model, found, true));
  CHECK(found.wrenches.outcome == Outcome::agree);
  const double needed = 420.0 * (0.06 * 0.5 - 0.08) * 0.06;
  CHECK(found.text.find(fmt::format("{:.6g}", needed)) != std::string::npos);
}

TEST_CASE("A stiff spring is in balance to the round-off of its angle", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
gravity = [0.3, -9.7, 0.8]
[[body]]
name = "m"
mass = 1.3
center_of_mass = [0.1, 0.03, -0.02]
inertia = [0.01, 0.012, 0.015]
[[joint]]
name = "h"
type = "revolute"
parent = { body = "ground", axis = [1, 2, 3], angle = 0.7 }
child = { body = "m", axis = [2, 1, 0], angle = 0.3 }
start.turn_z = { keep = 0.9, keep_speed = 0 }
spring.turn_z = { stiffness = 2e8 }
)toml");
  const AnalysisVerdict found = judge_statics(model, kMakers);
  INFO(format_analysis(model, found, true));
  for (const auto& solver : found.wrenches.solvers) CHECK(solver.audit_digits.value_or(0.0) >= 9.0);
}

TEST_CASE("What resists is held against the inertia that heavy neighbours lend to a light pin", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
gravity = [0, 0, -9.7]
[[body]]
name = "mast"
mass = 730.0
inertia = [41.0, 38.0, 44.0]
center_of_mass = [0.8, 0, 0]
[[body]]
name = "cross"
mass = 1.3e-6
inertia = [3e-13, 2e-13, 2e-13]
[[body]]
name = "load"
mass = 1250.0
inertia = [61.0, 58.0, 47.0]
center_of_mass = [0.6, 0, 0.15]
[[joint]]
name = "top"
type = "revolute"
parent = { body = "ground", z = [0, 1, 0], x = [1, 0, 0] }
child = { body = "mast", z = [0, 1, 0], x = [1, 0, 0] }
start.turn_z = { keep = 0.9, keep_speed = 0 }
[[joint]]
name = "swivel"
type = "revolute"
parent = { body = "mast", point = [2.1, 0, 0], z = [1, 0, 0], x = [0, 1, 0] }
child = { body = "cross", z = [1, 0, 0], x = [0, 1, 0] }
start.turn_z = { keep = 0.13, keep_speed = 0 }
[[joint]]
name = "pin"
type = "revolute"
parent = { body = "cross", z = [0, 1, 0], x = [1, 0, 0] }
child = { body = "load", z = [0, 1, 0], x = [1, 0, 0] }
start.turn_z = { keep = 0.2, keep_speed = 0 }
)toml");
  const AnalysisVerdict found = judge_statics(model, kMakers);
  INFO(format_analysis(model, found, true));
  REQUIRE(found.wrenches.outcome == Outcome::agree);
  const State& rest = found.wrenches.trajectories[0]->samples[0].state;
  CHECK(rest.q[0](0) == Approx(0.5 * EIGEN_PI).epsilon(1e-11));
  CHECK(rest.q[2](0) == Approx(std::atan2(0.15, 0.6)).epsilon(1e-11));
  CHECK(found.text.find("without stiffness, as near to its start as balance lets it be: turn_z of swivel") !=
        std::string::npos);
}

TEST_CASE("A beam that bends beyond what modes describe is named, not called singular", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
gravity = [0.6, 0.3, -9.8]
[[body]]
name = "rod"
[body.beam]
length = 0.7
elements = 10
section = { width_y = 0.022, width_z = 0.011 }
youngs_modulus = 7e6
poissons_ratio = 0.3
density = 1300.0
support = "cantilever"
modes = { bending_xz = [1, 2], bending_xy = [1] }
[[body]]
name = "bob"
mass = 0.15
inertia = [3e-4, 4e-4, 5e-4]
center_of_mass = [0.1, 0, 0.01]
[[joint]]
name = "root"
type = "weld"
parent = "ground"
child = { body = "rod", node = "first" }
[[joint]]
name = "tip"
type = "revolute"
parent = { body = "bob", z = [0, 1, 0], x = [1, 0, 0] }
child = { body = "rod", node = "last", z = [0, 1, 0], x = [1, 0, 0] }
start.turn_z = { keep = 0.4, keep_speed = 0 }
spring.turn_z = { stiffness = 0.7, free = 0.1 }
)toml");
  CHECK_THROWS_WITH(judge_statics(model, kMakers),
                    Catch::StartsWith("cartesian: at t = 0 s the frame of joint 'tip' has turned by 3.1") &&
                        Catch::Contains("through deformation alone"));
}

}  // namespace
}  // namespace concord::verification
