#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "closed_forms.h"
#include "common/error.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/report.h"

/// Analyses of machines whose verdict once hung by round-off: nothing acts, nothing decides, or a force has a kink.
namespace concord::verification {
namespace {

using compare::Outcome;
using compare::analyses::AnalysisVerdict;
using compare::analyses::format_analysis;
using compare::analyses::judge_inverse;
using compare::analyses::judge_linearization;
using compare::analyses::judge_statics;

/// Round-off decides whether the eigenvalues of a critically damped motion are real or a pair, in each solver anew.
TEST_CASE("A critically damped slider decays by two real modes in both solvers", "[analyses][quick]") {
  for (const double stiffness : {3.7, 41.0, 230.0, 1.9e3, 8.8e4}) {
    const double mass = 1.3;
    const Model model = parse(fmt::format(R"toml(format = 1
gravity = [0.3, -9.7, 1.2]
[[body]]
name = "box"
mass = {}
inertia = [0.04, 0.05, 0.07]
[[joint]]
name = "guide"
type = "translational"
parent = {{ body = "ground", point = [0.1, 0.2, 0.3], axis = [1, 2, -1], angle = 0.7 }}
child = "box"
start.slide_z = {{ keep = 0.1, keep_speed = 0 }}
spring.slide_z = {{ stiffness = {}, damping = {} }}
)toml",
                                          mass, stiffness, 2.0 * std::sqrt(stiffness * mass)));
    const AnalysisVerdict result = judge_linearization(model, kMakers, false);
    INFO(format_analysis(model, result, true));
    CHECK(result.wrenches.outcome == Outcome::agree);
    for (const auto& found : result.linearizations) {
      REQUIRE(found->modes.size() == 2);
      for (const auto& mode : found->modes) {
        CHECK(mode.eigenvalue.imag() == 0.0);
        CHECK(mode.eigenvalue.real() == Approx(-std::sqrt(stiffness / mass)).epsilon(1e-5));
      }
    }
  }
}

TEST_CASE("Two beams on a ball, on which nothing acts, have eighteen free modes", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
[[body]]
name = "left"
[body.beam]
length = 0.61
elements = 14
section = { width_y = 0.011, width_z = 0.017 }
youngs_modulus = 4.3e9
poissons_ratio = 0.35
density = 1150
support = "free_free"
modes = { bending_xy = [1], bending_xz = [1, 2], torsion = [1] }
[[body]]
name = "right"
[body.beam]
length = 0.37
elements = 12
section = { width_y = 0.009, width_z = 0.006 }
youngs_modulus = 2.1e9
poissons_ratio = 0.35
density = 1300
support = "free_free"
modes = { bending_xy = [1, 2], bending_xz = [1], torsion = [1] }
[[joint]]
name = "flight"
type = "free"
parent = "ground"
child = { body = "left", node = "first" }
start.slide_x = { keep = 0.3, keep_speed = 0 }
start.slide_y = { keep = -0.2, keep_speed = 0 }
start.slide_z = { keep = 0.1, keep_speed = 0 }
start.ball = { keep = { axis = [2, -1, 1], angle = 0.4 }, keep_speed = [0, 0, 0] }
[[joint]]
name = "elbow"
type = "spherical"
parent = { body = "left", node = "last" }
child = { body = "right", node = "first" }
start.ball = { keep = { axis = [1, 3, -1], angle = 0.9 }, keep_speed = [0, 0, 0] }
)toml");
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
  const AnalysisVerdict modes = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, modes, true));
  CHECK(modes.wrenches.outcome == Outcome::agree);
  for (const auto& found : modes.linearizations) {
    const auto is_free = [](const auto& mode) { return mode.is_free; };
    CHECK(std::count_if(found->modes.begin(), found->modes.end(), is_free) == 18);
  }
}

TEST_CASE("A pole that stands upright is not pushed over by round-off", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "lift"
mass = 3.1
inertia = [0.05, 0.06, 0.07]
[[body]]
name = "pole"
mass = 0.8
center_of_mass = [0, 0, 0.45]
inertia = [0.05, 0.05, 0.001]
[[body]]
name = "cap"
mass = 0.3
center_of_mass = [0, 0, 0.1]
inertia = [0.002, 0.002, 0.001]
[[joint]]
name = "guide"
type = "translational"
parent = "ground"
child = "lift"
start.slide_z = { keep = 0.3, keep_speed = 0 }
spring.slide_z = { stiffness = 210, free = 0.3 }
[[joint]]
name = "foot"
type = "universal"
parent = { body = "lift", point = [0, 0, 0.2] }
child = "pole"
start.turn_x = { keep = 0, keep_speed = 0 }
start.turn_y = { keep = 0, keep_speed = 0 }
[[joint]]
name = "neck"
type = "spherical"
parent = { body = "pole", point = [0, 0, 0.9] }
child = "cap"
start.ball = { keep = { axis = [1, 0, 0], angle = 0 }, keep_speed = [0, 0, 0] }
)toml");
  const AnalysisVerdict found = judge_statics(model, kMakers);
  INFO(format_analysis(model, found, true));
  CHECK(found.wrenches.outcome == Outcome::agree);
  for (const auto& row : found.numbers) {
    if (row.name == "unstable directions") CHECK(row.values[0] == 4.0);
    if (row.name == "slide_z of guide") CHECK(row.values[0] == Approx(0.3 - 4.2 * 9.81 / 210.0).epsilon(1e-10));
  }
}

/// Nothing of some eigenvalues is resolved: round-off decides whether they are real, a pair, or count as free.
TEST_CASE("Modes of a skate agree though its slow eigenvalues are round-off", "[analyses][quick]") {
  for (const char* gravity : {"[0, 0, 0]", "[2.899053227347742, 0, -9.371850958322197]"}) {
    INFO("gravity " << gravity);
    const Model model = parse(fmt::format(R"toml(format = 1
gravity = {}
[[body]]
name = "skate"
mass = 2
inertia = [0.1, 0.1, 0.15]
center_of_mass = [0, 0, 0.1]
[[joint]]
name = "edge"
type = "knife_edge"
parent = "ground"
child = "skate"
start.slide_x = {{ keep = 0, keep_speed = 0.3 }}
start.slide_y = {{ keep = 0 }}
start.turn_z = {{ keep = 0.4, keep_speed = 2 }}
)toml",
                                          gravity));
    const AnalysisVerdict found = judge_linearization(model, kMakers, false);
    INFO(format_analysis(model, found, true));
    CHECK(found.wrenches.outcome == Outcome::agree);
  }
}

TEST_CASE("A shaft whose bearings hold all its modes turns freely, as a rigid one", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
gravity = [0.4, -0.2, -9.7]
[[body]]
name = "shaft"
[body.beam]
length = 0.8
elements = 8
section = { diameter = 0.02 }
youngs_modulus = 2.0e11
poissons_ratio = 0.3
density = 7800
support = "craig_bampton"
damping_ratio = 0.02
static_modes = { bending_xy = [1], bending_xz = [1], axial = [1] }
[[body]]
name = "disk"
mass = 4
inertia = [0.04, 0.02, 0.02]
[[joint]]
name = "left"
type = "revolute"
parent = { body = "ground", z = [1, 0, 0], x = [0, 1, 0] }
child = { body = "shaft", node = "first", z = [1, 0, 0], x = [0, 1, 0] }
start.turn_z = { keep = 0, keep_speed = 0 }
[[joint]]
name = "right"
type = "revolute"
parent = { body = "ground", point = [0.8, 0, 0], z = [1, 0, 0], x = [0, 1, 0] }
child = { body = "shaft", node = "last", z = [1, 0, 0], x = [0, 1, 0] }
[[joint]]
name = "press_fit"
type = "weld"
parent = { body = "shaft", node = "4" }
child = "disk"
)toml");
  const AnalysisVerdict modes = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, modes, true));
  CHECK(modes.wrenches.outcome == Outcome::agree);
  for (const auto& row : modes.numbers) {
    if (row.name == "number of free modes") CHECK(row.values[0] == 2.0);
  }
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
}

TEST_CASE("A tire that just touches its road has no linearization", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
[[body]]
name = "wheel"
mass = 14
inertia = [0.4, 0.7, 0.4]
[[joint]]
name = "post"
type = "translational"
parent = "ground"
child = "wheel"
start.slide_z = { keep = 0.28, keep_speed = 0 }
[[road]]
name = "r"
profile = "flat"
[[tire]]
name = "t"
body = "wheel"
road = "r"
radius = 0.28
stiffness = 1.7e5
slip_stiffness = 2e4
cornering_stiffness = 2e4
friction = 0.8
)toml");
  CHECK_THROWS_WITH(judge_linearization(model, kMakers, false), Catch::Contains("kink in this very state"));
}

TEST_CASE("A load that begins to swing below a moving trolley has the same modes whatever round-off turns the trolley",
          "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "load"
mass = 11
inertia = [0.13, 0.13, 0.13]
[[body]]
name = "trolley"
mass = 23
inertia = [1, 1.2, 0.9]
[[joint]]
name = "rail"
type = "translational"
parent = { body = "ground", x = [0, 1, 0], z = [1, 0, 0] }
child = { body = "trolley", x = [0, 1, 0], z = [1, 0, 0] }
start.slide_z = { keep = 0, keep_speed = 1.7 }
spring.slide_z = { damping = 12 }
[[joint]]
name = "rope"
type = "spherical"
parent = { body = "load", point = [0, 0, 2.1] }
child = "trolley"
start.ball = { keep = { axis = [0, 1, 0], angle = 0.06 }, keep_speed = [0, 0, 0] }
)toml");
  const AnalysisVerdict verdict = judge_linearization(model, kMakers, false);
  CHECK(verdict.wrenches.findings.empty());
  CHECK(verdict.wrenches.outcome == Outcome::agree);
}

/// A skate of 15 g that pulls 219 kg a long way from the origin: round-off decides whether one of its slow motions is
/// free, and the others move by what it decides.
TEST_CASE("Modes beside one that round-off finds free or slow agree as far as that leaves them", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
gravity = [5.43, 1.64, -7.16]
[[body]]
name = "skate"
mass = 0.005
center_of_mass = [42.05, 22.13, -18.82]
inertia = [131.6, 107.6, 146.2, 2.226, 33.42, 4.404]
[[body]]
name = "load"
mass = 218.9
center_of_mass = [-9.089, 20.03, 35.25]
inertia = [5.877e+05, 6.481e+05, 6.747e+05, 8522, 3.061e+04, 7527]
[[joint]]
name = "blade"
type = "knife_edge"
parent = { body = "ground", point = [99.17, -42.53, -24.11], euler_parameters = [0.1823, 0.1323, 0.7781, -0.5864] }
child = { body = "skate", point = [91.77, -57.8, -42.1], euler_parameters = [0.3701, 0.1753, 0.8981, 0.1601] }
start.slide_x = { keep = -56.03, keep_speed = 100 }
start.slide_y = { keep=300, guess_speed = -2.873 }
start.turn_z = { keep = -0.1641, keep_speed = 0.02014 }
[[joint]]
name = "hitch"
type = "spherical"
parent = { body = "skate", point = [133.1, -98.73, 53], euler_parameters = [0.717, -0.5086, -0.08193, -0.4696] }
child = { body = "load", point = [72.91, -79.65, 139.6], euler_parameters = [0.2025, -0.2299, 0.2684, 0.9133] }
start.ball = { keep = { euler_parameters = [0.4098, 0.3084, 0.1068, 0.8518] }, keep_speed = [-0.01946, -0.2977, -0.007031] }
)toml");
  const AnalysisVerdict verdict = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, verdict, true));
  CHECK(verdict.wrenches.outcome == Outcome::agree);
}

/// A barrel's spring unwinds by 8 rad, and the last wheel of its train by 1600 rad: what is left of all torques there
/// is the round-off of these turns, and nothing else is there to compare it with but the spring's own terms.
TEST_CASE("A train of gears unwinds the spring of its barrel by hundreds of turns", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
[[body]]
name = "barrel"
mass = 0.2
inertia = [1e-4, 1e-4, 2e-4]
[[body]]
name = "centre"
mass = 0.02
inertia = [1e-6, 1e-6, 2e-6]
[[body]]
name = "second"
mass = 0.01
inertia = [5e-7, 5e-7, 1e-6]
[[joint]]
name = "B"
type = "revolute"
parent = { body = "ground", point = [0.1, 0, 0] }
child = "barrel"
start.turn_z = { keep = 0, keep_speed = 0 }
spring.turn_z = { stiffness = 0.01, preload = -0.08, damping = 0.2 }
[[joint]]
name = "C"
type = "revolute"
parent = { body = "ground", point = [0.05, 0, 0] }
child = "centre"
[[joint]]
name = "S"
type = "revolute"
parent = { body = "ground", point = [0.05, 0.05, 0] }
child = "second"
[[coupling]]
name = "first"
terms = [{ joint = "B", coordinate = "turn_z", factor = 20 }, { joint = "C", coordinate = "turn_z", factor = 1 }]
[[coupling]]
name = "last"
terms = [{ joint = "C", coordinate = "turn_z", factor = 10 }, { joint = "S", coordinate = "turn_z", factor = 1 }]
)toml");
  const AnalysisVerdict verdict = judge_statics(model, kMakers);
  CHECK(verdict.wrenches.findings.empty());
  CHECK(verdict.wrenches.outcome == Outcome::agree);
  CHECK(verdict.wrenches.trajectories[0]->samples.front().state.q[2](0) == Approx(1600.0));
}

/// Two panels on hinges with springs, and nothing else that acts.
Model sprung_panels() {
  return parse(R"toml(format = 1
[[body]]
name = "panel"
mass = 5
inertia = [0.3, 0.4, 0.5]
center_of_mass = [0.5, 0, 0]
[[body]]
name = "tip"
mass = 4
inertia = [0.3, 0.4, 0.5]
center_of_mass = [0.5, 0, 0]
[[joint]]
name = "root"
type = "revolute"
parent = "ground"
child = "panel"
start.turn_z = { keep = 1.5, keep_speed = 0 }
spring.turn_z = { stiffness = 5, damping = 1 }
[[joint]]
name = "hinge"
type = "revolute"
parent = { body = "panel", point = [1, 0, 0] }
child = "tip"
start.turn_z = { keep = -1.4, keep_speed = 0 }
spring.turn_z = { stiffness = 6, damping = 1 }
)toml");
}

TEST_CASE("Panels that springs unfold to a rest in which nothing acts agree on where that is", "[analyses][quick]") {
  const AnalysisVerdict verdict = judge_statics(sprung_panels(), kMakers);
  CHECK(verdict.wrenches.findings.empty());
  CHECK(verdict.wrenches.outcome == Outcome::agree);
  CHECK(verdict.wrenches.trajectories[0]->samples.front().state.q[1](0) == Approx(0.0).margin(1e-9));
}

/// Motor and damper, or motor and spring, are forces a thousand times as large as what is left of them, or of nothing.
TEST_CASE(
    "A motor that moves a slide against its damper, or holds a hinge against its spring, is found by both solvers",
    "[analyses][quick]") {
  const Model lifted = parse(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "carriage"
mass = 1.3
inertia = [0.4, 0.5, 0.6]
[[joint]]
name = "guide"
type = "translational"
parent = "ground"
child = "carriage"
start.slide_z = { keep = 0, keep_speed = 1.1 }
spring.slide_z = { damping = 3e6 }
)toml");
  for (const Model& model : {lifted, sprung_panels()}) {
    const AnalysisVerdict verdict = judge_inverse(model, kMakers, {});
    INFO(format_analysis(model, verdict, true));
    CHECK(verdict.wrenches.findings.empty());
    CHECK(verdict.wrenches.outcome == Outcome::agree);
  }
}

}  // namespace
}  // namespace concord::verification
