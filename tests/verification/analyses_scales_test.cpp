#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "closed_forms.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/report.h"

/// Machines in which what an analysis finds vanishes, cancels or is small beside what it is found from.
namespace concord::verification {
namespace {

using compare::analyses::AnalysisVerdict;
using compare::analyses::format_analysis;
using compare::analyses::judge_inverse;
using compare::analyses::judge_linearization;
using compare::analyses::judge_statics;

void check_agrees(const Model& model, const AnalysisVerdict& result) {
  INFO(format_analysis(model, result, true));
  CHECK(result.wrenches.outcome == compare::Outcome::agree);
}

std::string body(const std::string& name, double mass, const std::string& center) {
  return fmt::format("[[body]]\nname = \"{}\"\nmass = {}\ncenter_of_mass = {}\ninertia = [0.011, 0.019, 0.023]\n", name,
                     mass, center);
}

}  // namespace

// Detects a scale that counts what a joint passes on alone: driver and spring of one joint balance each other in it.
TEST_CASE("A driver that holds the spring of its own joint is in balance", "[analyses][quick]") {
  const Model model = parse("format = 1\n" + body("sled", 1.3, "[0, 0, 0]") + body("door", 0.9, "[0.1, 0.02, 0]") +
                            R"([[joint]]
name = "rail"
type = "translational"
both = { axis = [1, 2, 3], angle = 0.6 }
parent = "ground"
child = "sled"
drive.slide_z = { law = "constant_speed", speed = 0, start = 0.13 }
spring.slide_z = { stiffness = 1100 }
[[joint]]
name = "hinge"
type = "revolute"
parent = "sled"
child = "door"
spring.turn_z = { stiffness = 2.3 }
start.turn_z = { keep = 0.2, keep_speed = 0 }
)");
  check_agrees(model, judge_linearization(model, kMakers, true));
  const AnalysisVerdict statics = judge_statics(model, kMakers);
  INFO(format_analysis(model, statics, true));
  CHECK(statics.wrenches.findings.empty());  // no reaction carries anything: there is none to agree on
}

// Detects digits that a force on a joint speed is held to by what the joint passes on, which is nothing here.
TEST_CASE("A skate at rest between its own springs is in balance", "[analyses][quick]") {
  const Model model = parse("format = 1\n" + body("skate", 1.1, "[0.05, 0, 0]") + R"([[joint]]
name = "edge"
type = "knife_edge"
parent = "ground"
child = "skate"
start.slide_x = { keep = 0, keep_speed = 0 }
start.slide_y = { keep = 0 }
start.turn_z = { keep = 0.4, keep_speed = 0 }
spring.slide_x = { stiffness = 43 }
spring.slide_y = { stiffness = 31 }
spring.turn_z = { stiffness = 0.6, free = 0.4 }
)");
  check_agrees(model, judge_statics(model, kMakers));
}

/// Eight digits of a linkage's size are left of places so far away, and no more of its angles.
TEST_CASE("A linkage far from the origin comes to rest as exactly as its places are known", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "crank"
mass = 0.6
inertia = [7.5e-6, 1.25e-4, 1.25e-4]
center_of_mass = [0.025, 0, 0]
[[body]]
name = "coupler"
mass = 0.8
inertia = [1e-5, 1.5e-3, 1.5e-3]
center_of_mass = [0.075, 0, 0]
[[body]]
name = "rocker"
mass = 0.6
inertia = [7.5e-6, 7.8e-4, 7.8e-4]
center_of_mass = [0.0625, 0, 0]
[[joint]]
name = "A"
type = "revolute"
parent = { body = "ground", point = [2.5e6, 2e7, 100], z = [0, 1, 0], x = [1, 0, 0] }
child = { body = "crank", z = [0, 1, 0], x = [1, 0, 0] }
start.turn_z = { keep = 0.5, keep_speed = 0 }
[[joint]]
name = "B"
type = "revolute"
parent = { body = "crank", point = [0.05, 0, 0], z = [0, 1, 0], x = [1, 0, 0] }
child = { body = "coupler", z = [0, 1, 0], x = [1, 0, 0] }
start.turn_z = { guess = -1.2 }
[[joint]]
name = "C"
type = "spherical"
parent = { body = "coupler", point = [0.15, 0, 0] }
child = { body = "rocker", point = [0.125, 0, 0] }
[[joint]]
name = "D"
type = "revolute"
parent = { body = "ground", point = [2500000.15, 2e7, 100], z = [0, 1, 0], x = [1, 0, 0] }
child = { body = "rocker", z = [0, 1, 0], x = [1, 0, 0] }
start.turn_z = { guess = -1.7 }
)toml");
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == compare::Outcome::agree);
}

// Detects a wrench that vanishes by balance and is held to more digits than the places from which it follows.
TEST_CASE("A balanced seesaw with weights on stops agrees as far as its angle is known", "[analyses][quick]") {
  std::string text = "format = 1\ngravity = [0, 0, -9.81]\n" + body("bar", 4.2, "[0, 0, 0]") +
                     body("left", 1.2, "[0, 0, 0]") + body("right", 1.2, "[0, 0, 0]") + R"([[joint]]
name = "pivot"
type = "revolute"
both = { z = [0, 1, 0], x = [1, 0, 0] }
parent = "ground"
child = "bar"
start.turn_z = { keep = 0.0, keep_speed = 0 }
)";
  for (const auto& [name, x] : {std::pair("left", 0.45), std::pair("right", -0.45)}) {
    text += fmt::format(R"([[joint]]
name = "guide_{0}"
type = "translational"
parent = {{ body = "bar", point = [{1}, 0, 0] }}
child = "{0}"
start.slide_z = {{ keep = 0.2, keep_speed = 0 }}
spring.slide_z = {{ lower_stop = {{ at = 0.1, stiffness = 2.1e4, width = 0.005, damping = 5 }} }}
)",
                        name, x);
  }
  const Model model = parse(text);
  check_agrees(model, judge_statics(model, kMakers));
}

// Detects a search whose steps the fast side of a gear sets: 110 turns of the motor are one of the link.
TEST_CASE("A link that a gear ties to its motor is found hanging", "[analyses][quick]") {
  const Model model = parse("format = 1\ngravity = [0, 0, -9.81]\n" + body("link", 5.2, "[0.21, 0, 0]") +
                            body("rotor", 0.1, "[0, 0, 0]") + R"([[joint]]
name = "hinge"
type = "revolute"
both = { z = [0, 1, 0], x = [1, 0, 0] }
parent = "ground"
child = "link"
start.turn_z = { keep = 0.3, keep_speed = 0 }
[[joint]]
name = "shaft"
type = "revolute"
both = { z = [0, 1, 0], x = [1, 0, 0] }
parent = "ground"
child = "rotor"
[[coupling]]
name = "gear"
terms = [{ joint = "shaft", coordinate = "turn_z", factor = 1 }, { joint = "hinge", coordinate = "turn_z", factor = -110 }]
)");
  check_agrees(model, judge_statics(model, kMakers));
}

// Detects a search that never becomes Newton's method, because its longest step grows while forces fall.
TEST_CASE("A mass on a spring so soft that it swings for minutes is found at rest", "[analyses][quick]") {
  const std::string slide = R"([[joint]]
name = "rail"
type = "translational"
both = { z = [1, 0, 0], x = [0, 1, 0] }
parent = "ground"
child = "sled"
start.slide_z = { keep = 0.13, keep_speed = 0 }
spring.slide_z = { stiffness = 0.017 }
)";
  const Model sled =
      parse("format = 1\ngravity = [0, 0, -9.81]\n[[body]]\nname = \"sled\"\nmass = 1180\ninertia = [700, 800, 900]\n" +
            slide);
  check_agrees(sled, judge_statics(sled, kMakers));
  const Model geared = parse("format = 1\ngravity = [0, 0, -9.81]\n" + body("wheel", 1.1, "[0, 0, 0]") +
                             body("pinion", 0.9, "[0, 0, 0]") + R"([[joint]]
name = "slow"
type = "revolute"
parent = "ground"
child = "wheel"
start.turn_z = { keep = 0.14, keep_speed = 0 }
spring.turn_z = { stiffness = 0.023, damping = 0.04 }
[[joint]]
name = "fast"
type = "revolute"
parent = "ground"
child = "pinion"
[[coupling]]
name = "gear"
terms = [{ joint = "slow", coordinate = "turn_z", factor = 1 }, { joint = "fast", coordinate = "turn_z", factor = 0.027 }]
)");
  check_agrees(geared, judge_statics(geared, kMakers));
}

/// A cantilever of this length [m] with a block at its tip, and all machines similar to it.
std::string cantilever(double length) {
  return fmt::format(R"(format = 1
[[body]]
name = "beam"
beam = {{ length = {0}, section = {{ width_y = {1}, width_z = {6} }}, youngs_modulus = {2}, poissons_ratio = 0.3, density = 2900, support = "craig_bampton", elements = 12, modes = {{ bending_xy = [1, 2, 3], bending_xz = [1, 2, 3] }}, static_modes = {{ bending_xy = [1, 2], bending_xz = [1, 2], torsion = [1], axial = [1] }} }}
[[joint]]
name = "wall"
type = "weld"
parent = "ground"
child = {{ body = "beam", node = "first" }}
[[body]]
name = "block"
mass = {3}
inertia = [{4}, {4}, {5}]
[[joint]]
name = "tip"
type = "weld"
parent = {{ body = "beam", node = "last" }}
child = "block"
)",
                     length, 0.01 * length, 2e11 * length * length, 0.1 * std::pow(length, 3),
                     4e-5 * std::pow(length, 5), 5e-5 * std::pow(length, 5), 0.014 * length);
}

// Detects velocities that are made orthogonal in units in which modal coordinates are not of the size of the others.
TEST_CASE("A cantilever of a tenth of a millimetre has the modes of one of ten kilometres", "[analyses]") {
  std::vector<double> eigenvalues;
  for (const double length : {1.0, 1e-4, 1e4}) {
    const Model model = parse(cantilever(length));
    const AnalysisVerdict result = judge_linearization(model, kMakers, false);
    check_agrees(model, result);
    for (const compare::analyses::NumberRow& row : result.numbers) {
      INFO(row.name);
      if (row.name.starts_with("shape of mode")) CHECK(row.digits >= 9.0);
      if (row.name == "eigenvalue 3") eigenvalues.push_back(row.values[0]);
    }
  }
  REQUIRE(eigenvalues.size() == 3);
  for (const double one : eigenvalues) CHECK(one == Approx(eigenvalues[0]).epsilon(1e-8));
}

// Detects a resolution that does not know that couplings pass accelerations on by the ratio of their factors.
TEST_CASE("A table on two screw jacks is linearized at rest", "[analyses][quick]") {
  std::string text = "format = 1\ngravity = [0, 0, -9.81]\n" + body("table", 52, "[0, 0, 0]") + R"([[joint]]
name = "lift"
type = "translational"
parent = "ground"
child = "table"
)";
  for (const auto& [name, driver] :
       {std::pair("near", "drive.turn_z = { law = \"smooth_step\", t0 = 0, t1 = 1, from = 0, to = 55 }\n"),
        std::pair("far", "")}) {
    text += body(name, 0.8, "[0, 0, 0]") + fmt::format(R"([[joint]]
name = "screw_{0}"
type = "revolute"
parent = {{ body = "ground", point = [0.4, 0.3, 0] }}
child = "{0}"
{1}[[coupling]]
name = "thread_{0}"
terms = [{{ joint = "lift", coordinate = "slide_z", factor = 1 }}, {{ joint = "screw_{0}", coordinate = "turn_z", factor = -0.0021 }}]
)",
                                                       name, driver);
  }
  const Model model = parse(text);
  check_agrees(model, judge_linearization(model, kMakers, false));
}

TEST_CASE("Nothing is asked of a nut on a screw in space, and nothing comes back", "[analyses][quick]") {
  const Model model = parse(R"(format = 1
[[body]]
name = "nut"
mass = 1.1
inertia = [0.01, 0.01, 0.02]
[[joint]]
name = "thread"
type = "screw"
parent = { body = "ground", axis = [1, 0.3, 0.2], angle = 0.8 }
child = "nut"
lead = 0.012
start.turn = { keep_speed = 3.1, keep = 0.0 }
)");
  check_agrees(model, judge_inverse(model, kMakers, {}));
}

TEST_CASE("Modes about a rest that velocity constraints leave open are refused", "[analyses][quick]") {
  const Model model = parse("format = 1\ngravity = [0, 0, -9.81]\n" + body("ball", 2.1, "[0, 0, 0]") +
                            body("bob", 1.1, "[0, 0, -0.05]") + R"([[joint]]
name = "floor"
type = "rolling_ball"
radius = 0.11
parent = { body = "ground", point = [0, 0, 0.11] }
child = "ball"
start.slide_x = { keep = 0 }
start.slide_y = { keep = 0 }
start.ball = { keep = { axis = [1, 2, 3], angle = 0.4 }, keep_speed = [0, 0, 0] }
[[joint]]
name = "cross"
type = "universal"
parent = "ball"
child = "bob"
start.turn_x = { keep = 0.45, keep_speed = 0 }
start.turn_y = { keep = 0.1, keep_speed = 0 }
)");
  CHECK_THROWS_WITH(judge_linearization(model, kMakers, true), Catch::Contains("the equilibrium is not determined"));
}

}  // namespace concord::verification
