#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>

#include "analysis_numbers.h"
#include "closed_forms.h"
#include "common/error.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/report.h"
#include "compare/equilibrium/equilibrium.h"
#include "compare/equilibrium/rests.h"
#include "judged_machines.h"

/// Rests that statics once did not find, or that it found though the statement does not determine them.
namespace concord::verification {
namespace {

using compare::Equilibrium;
using compare::find_equilibrium;
using compare::find_rests;
using compare::held_at_start;
using compare::one_sample;
using compare::Outcome;
using compare::refuse_undetermined_rest;
using compare::Rests;
using compare::Solvers;
using compare::analyses::AnalysisVerdict;
using compare::analyses::format_analysis;
using compare::analyses::judge_linearization;
using compare::analyses::judge_statics;

/// A mode that turns frames and hardly moves a point must be stepped by its turn.
TEST_CASE("A thin cantilever with a torsion mode bends and twists under small loads", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
[[body]]
name = "blade"
[body.beam]
length = 2.1
elements = 12
section = { width_y = 0.008, width_z = 0.015 }
youngs_modulus = 6.9e10
poissons_ratio = 0.33
density = 2700
support = "craig_bampton"
modes = { bending_xy = [1] }
static_modes = { torsion = [1] }
[[joint]]
name = "root"
type = "weld"
parent = { body = "ground", point = [0.2, -0.1, 0.3], axis = [1, 2, -1], angle = 0.7 }
child = { body = "blade", node = "first" }
[[load]]
name = "tip"
body = "blade"
node = "last"
force = [0.1, 0.4, -0.3]
torque = [0.02, 0, 0]
)toml");
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
  const AnalysisVerdict modes = judge_linearization(model, kMakers, true);
  INFO(format_analysis(model, modes, true));
  CHECK(modes.wrenches.outcome == Outcome::agree);
}

struct SlenderChain {
  const char* gravity;
  std::array<double, 2> diameters;  // [m]
  std::array<double, 4> turns;      // at the start: of the hook, of the middle [rad]
  double damping_ratio;
};

/// Two steel rods on universal joints, a bob welded to the lower one.
Model model_of(const SlenderChain& chain) {
  const auto rod = [&](const char* name, double diameter) {
    return fmt::format(R"toml(
[[body]]
name = "{}"
[body.beam]
length = 0.33
elements = 8
section = {{ diameter = {} }}
youngs_modulus = 2.0e11
poissons_ratio = 0.3
density = 7800
support = "craig_bampton"
damping_ratio = {}
static_modes = {{ bending_xy = [1], bending_xz = [1], axial = [1] }}
)toml",
                       name, diameter, chain.damping_ratio);
  };
  const auto universal = [](const char* name, const char* parent, const char* child, double turn_x, double turn_y) {
    return fmt::format(R"toml(
[[joint]]
name = "{}"
type = "universal"
parent = {{ {}, z = [0, 1, 0], x = [1, 0, 0] }}
child = {{ body = "{}", node = "first", z = [0, 1, 0], x = [1, 0, 0] }}
start.turn_x = {{ keep = {}, keep_speed = 0 }}
start.turn_y = {{ keep = {}, keep_speed = 0 }}
)toml",
                       name, parent, child, turn_x, turn_y);
  };
  return parse(fmt::format("format = 1\ngravity = {}\n", chain.gravity) + rod("upper", chain.diameters[0]) +
               rod("lower", chain.diameters[1]) + R"toml(
[[body]]
name = "bob"
mass = 0.8
inertia = [0.002, 0.001, 0.003]
[[joint]]
name = "grip"
type = "weld"
parent = { body = "lower", node = "last" }
child = "bob"
)toml" + universal("hook", "body = \"ground\"", "upper", chain.turns[0], chain.turns[1]) +
               universal("middle", "body = \"upper\", node = \"last\"", "lower", chain.turns[2], chain.turns[3]));
}

/// Turns by a third of a radian displace joints in second order: of a stiff rod's modes that would be forces of tons.
TEST_CASE("A chain of slender rods swings down from aslant to hang straight", "[analyses][quick]") {
  const Model model = model_of({"[0.4, -0.2, -9.7]", {0.008, 0.008}, {0.2, -0.1, -0.4, 0.3}, 0.02});
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
  CHECK(value_of(rest, "directions without stiffness") == 1.0);
}

/// On its way the first one makes some seven turns about the vertical, all of which lead back; the second one leaps to
/// and fro across a narrow valley until its steps are halved.
TEST_CASE("A chain of slender rods finds its rest after many turns and across a narrow valley", "[analyses]") {
  for (const SlenderChain& chain :
       {SlenderChain{"[0, 0, -9.81]", {0.008, 0.004}, {0.4113, 0.8527, 0.2285, 0.2030}, 0.01},
        SlenderChain{"[0.4, -0.2, -9.7]", {0.004, 0.008}, {0.0, 0.0, 0.0, 0.0}, 0.0}}) {
    const Model model = model_of(chain);
    const AnalysisVerdict rest = judge_statics(model, kMakers);
    INFO(format_analysis(model, rest, true));
    CHECK(rest.wrenches.outcome == Outcome::agree);
  }
}

/// The fast shaft of a train goes round a hundred times while its link turns by a right angle.
TEST_CASE("A link on two gears in a row comes to hang, its motor moved by as much as the ratios say",
          "[analyses][quick]") {
  const auto shaft = [](const char* name, const char* body, double start) {
    return fmt::format(R"toml(
[[body]]
name = "{0}"
mass = 0.1
inertia = [0.000011, 0.000019, 0.000023]
[[joint]]
name = "{1}"
type = "revolute"
both = {{ z = [0, 1, 0], x = [1, 0, 0] }}
parent = "ground"
child = "{0}"
start.turn_z = {{ guess = {2} }}
)toml",
                       body, name, start);
  };
  const Model model = parse(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "link"
mass = 5.2
inertia = [0.011, 0.019, 0.023]
center_of_mass = [0.21, 0, 0]
[[joint]]
name = "hinge"
type = "revolute"
both = { z = [0, 1, 0], x = [1, 0, 0] }
parent = "ground"
child = "link"
start.turn_z = { keep = 0.3, keep_speed = 0 }
[[coupling]]
name = "first"
terms = [
  { joint = "M", coordinate = "turn_z", factor = 1 },
  { joint = "hinge", coordinate = "turn_z", factor = -21 },
]
[[coupling]]
name = "second"
terms = [
  { joint = "R", coordinate = "turn_z", factor = 1 },
  { joint = "M", coordinate = "turn_z", factor = 17 },
]
)toml" + shaft("M", "mid", 6.3) +
                            shaft("R", "rotor", -107.1));
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
  for (const auto& solver : both_solvers(model)) {
    const State hanging = find_equilibrium(model, *solver).state;
    CHECK(hanging.q[0](0) == Approx(EIGEN_PI / 2.0).epsilon(1e-12));
    CHECK(hanging.q[2](0) == Approx(-21.0 * 17.0 * EIGEN_PI / 2.0).epsilon(1e-12));
  }
}

/// By hand: the nut sinks until the spring carries it, by m g / k, and its screw goes round for that 490 rad.
TEST_CASE("A nut on a fine thread comes to rest as far down as its spring says, after all the turns of its screw",
          "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "screw"
mass = 1.2
inertia = [0.002, 0.003, 0.001]
[[body]]
name = "nut"
mass = 0.6
inertia = [0.001, 0.002, 0.001]
[[joint]]
name = "bearing"
type = "revolute"
parent = "ground"
child = "screw"
start.turn_z = { keep = 0, keep_speed = 0 }
spring.turn_z = { damping = 0.02 }
[[joint]]
name = "thread"
type = "screw"
parent = "screw"
child = "nut"
lead = 0.0004
[[joint]]
name = "guide"
type = "translational"
parent = "ground"
child = "nut"
spring.slide_z = { stiffness = 30 }
)toml");
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
  CHECK(value_of(rest, "slide_z of guide") == Approx(-0.6 * 9.81 / 30.0).epsilon(1e-10));
  CHECK(value_of(rest, "turn_z of bearing") == Approx(0.6 * 9.81 / 30.0 / 0.0004).epsilon(1e-10));
}

/// A closed form: the torque of the mainspring balances the motor's, 125 rad from where the barrel starts.
TEST_CASE("A mainspring comes to rest after twenty turns of its barrel", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
[[body]]
name = "barrel"
mass = 0.3
inertia = [2e-4, 3e-4, 2.5e-4]
[[joint]]
name = "arbor"
type = "revolute"
parent = { body = "ground", point = [0.1, 0.2, -0.1], axis = [1, 1, 3], angle = "40 deg" }
child = { body = "barrel", axis = [1, -1, 2], angle = "30 deg" }
start.turn_z = { keep = 0, keep_speed = 0 }
spring.turn_z = { stiffness = 0.02, free = 30, actuator = -3.1 }
)toml");
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
  CHECK(value_of(rest, "turn_z of arbor") == Approx(30.0 - 3.1 / 0.02).epsilon(1e-10));
}

/// A gear that moves a ram slowly into its stop takes many turns, each of which nothing resists yet.
TEST_CASE("A press comes to rest on the stop of its ram, ten turns of the flywheel away", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
gravity = [0.4, -0.3, -9.7]
[[body]]
name = "wheel"
mass = 190
inertia = [31, 29, 50]
[[body]]
name = "ram"
mass = 520
inertia = [10, 11, 9]
[[joint]]
name = "shaft"
type = "revolute"
parent = { body = "ground", point = [0.3, 0.1, 0.2], axis = [1, 0, 2], angle = "20 deg" }
child = "wheel"
start.turn_z = { keep = 0, keep_speed = 0 }
[[joint]]
name = "guide"
type = "translational"
parent = "ground"
child = "ram"
spring.slide_z = { lower_stop = { at = -0.8, stiffness = 2e8, width = 0.002 } }
[[coupling]]
name = "thread"
terms = [
  { joint = "guide", coordinate = "slide_z", factor = 1 }, { joint = "shaft", coordinate = "turn_z", factor = -0.013 }]
)toml");
  const AnalysisVerdict verdict = judge_statics(model, kMakers);
  INFO(format_analysis(model, verdict, true));
  CHECK(verdict.wrenches.outcome == Outcome::agree);
}

/// The stiffness of a swinging machine, kept for a step too long, had an upright spin held by what is round-off.
TEST_CASE("A body on a massless rod below a link hangs and turns freely about its line", "[analyses]") {
  const Model model = parse(R"toml(format = 1
gravity = [1, 2, -9]
[[body]]
name = "link"
mass = 3.0
inertia = [0.0108, 0.0162, 0.0135, 0.00108, -0.00054, 0.00162]
center_of_mass = [0.12, 0.03, 0.012]
[[body]]
name = "bob"
mass = 1.5
inertia = [0.0108, 0.0162, 0.0135, 0.00108, -0.00054, 0.00162]
center_of_mass = [0.03, 0.03, 0.012]
[[joint]]
name = "hinge"
type = "revolute"
parent = "ground"
child = "link"
start.turn_z = { keep = 0.2, keep_speed = 0 }
[[joint]]
name = "rod"
type = "distance"
parent = { body = "link", point = [0.18, 0, 0], axis = [1, 1, 0], angle = 0.7 }
child = { body = "bob", point = [0.012, 0.018, 0] }
length = 0.24
start.ball = { keep = { axis = [0, 0, 1], angle = 0 }, keep_speed = [0, 0, 0] }
start.turn_x = { keep = 0, keep_speed = 0 }
start.turn_y = { keep = 0, keep_speed = 0 }
)toml");
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
  CHECK(value_of(rest, "directions without stiffness") == 1.0);
}

/// Round-off of the free direction mixed a linkage's way into that of the sledge that carries it.
TEST_CASE("A sledge that nothing holds along its way rests where it starts, far down it too", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "sledge"
mass = 1400
inertia = [310, 1100, 1300]
[[joint]]
name = "way"
type = "free"
parent = "ground"
child = "sledge"
start.slide_x = { keep = 2400, keep_speed = 0 }
start.slide_y = { keep = 0, keep_speed = 0 }
start.slide_z = { keep = 0, keep_speed = 0 }
start.ball = { keep = { axis = [0, 0, 1], angle = 0 }, keep_speed = [0, 0, 0] }
[[bushing]]
name = "runners"
parent = "ground"
child = "sledge"
stiffness = [0, 1.2e5, 1.1e5, 1e5, 1.3e5, 1e5]
[[body]]
name = "crank"
mass = 0.3
inertia = [1.5e-5, 2.5e-4, 2.5e-4]
center_of_mass = [0.05, 0, 0]
[[body]]
name = "coupler"
mass = 0.5
inertia = [2e-5, 3e-3, 3e-3]
center_of_mass = [0.15, 0, 0]
[[body]]
name = "rocker"
mass = 0.3
inertia = [1.5e-5, 1.6e-3, 1.6e-3]
center_of_mass = [0.125, 0, 0]
[[joint]]
name = "A"
type = "revolute"
parent = { body = "sledge", z = [0, 1, 0], x = [1, 0, 0] }
child = { body = "crank", z = [0, 1, 0], x = [1, 0, 0] }
start.turn_z = { keep = 0.5, keep_speed = 0 }
[[joint]]
name = "B"
type = "revolute"
parent = { body = "crank", point = [0.1, 0, 0], z = [0, 1, 0], x = [1, 0, 0] }
child = { body = "coupler", z = [0, 1, 0], x = [1, 0, 0] }
start.turn_z = { guess = -1.2 }
[[joint]]
name = "C"
type = "spherical"
parent = { body = "coupler", point = [0.3, 0, 0] }
child = { body = "rocker", point = [0.25, 0, 0] }
[[joint]]
name = "D"
type = "revolute"
parent = { body = "sledge", point = [0.3, 0, 0], z = [0, 1, 0], x = [1, 0, 0] }
child = { body = "rocker", z = [0, 1, 0], x = [1, 0, 0] }
start.turn_z = { guess = -1.7 }
)toml");
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
  CHECK(value_of(rest, "slide_x of way") == Approx(2400.0).epsilon(1e-13));
}

/// Springs at their free lengths exert nothing, but what they add up is not known better than to round-off.
TEST_CASE("What a relaxed radial spring does not resist is free, not unstable by round-off", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
[[body]]
name = "wheel"
mass = 0.8
inertia = [0.7, 0.7, 0.7]
[[joint]]
name = "pin"
type = "revolute"
parent = "ground"
child = "wheel"
start.turn_z = { keep = 0, keep_speed = 0 }
[[line_spring]]
name = "spoke"
parent = { body = "ground", point = [3.25, 0, 0] }
child = { body = "wheel", point = [0.75, 0, 0] }
stiffness = 310
free = 2.5
)toml");
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(value_of(rest, "directions without stiffness") == 1.0);
  CHECK(value_of(rest, "unstable directions") == 0.0);
  const AnalysisVerdict modes = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, modes, true));
  CHECK(modes.wrenches.outcome == Outcome::agree);
  for (const auto& found : modes.linearizations) {
    CHECK(std::all_of(found->modes.begin(), found->modes.end(), [](const auto& mode) { return mode.is_free; }));
  }
}

TEST_CASE("A body between six relaxed springs through its centre turns freely", "[analyses][quick]") {
  std::string text = R"toml(format = 1
[[body]]
name = "knot"
mass = 0.8
inertia = [0.7, 0.7, 0.7]
[[joint]]
name = "flight"
type = "free"
parent = "ground"
child = "knot"
start.slide_x = { keep = 0, keep_speed = 0 }
start.slide_y = { keep = 0, keep_speed = 0 }
start.slide_z = { keep = 0, keep_speed = 0 }
start.ball = { keep = { axis = [0, 0, 1], angle = 0 }, keep_speed = [0, 0, 0] }
)toml";
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      const Vec3 along = sign * Vec3::Unit(axis);
      const Vec3 from = 2.0 * along;
      const Vec3 to = 0.5 * along;
      text += fmt::format(
          "[[line_spring]]\nname = \"s{}{}\"\nstiffness = 230\nfree = 1.5\n"
          "parent = {{ body = \"ground\", point = [{}, {}, {}] }}\n"
          "child = {{ body = \"knot\", point = [{}, {}, {}] }}\n",
          axis, sign > 0.0 ? "+" : "-", from.x(), from.y(), from.z(), to.x(), to.y(), to.z());
    }
  }
  const Model model = parse(text);
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
  CHECK(value_of(rest, "directions without stiffness") == 3.0);
  const AnalysisVerdict modes = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, modes, true));
  CHECK(modes.wrenches.outcome == Outcome::agree);
}

/// Opposite links equal, a / sin(alpha) = b / sin(beta).
Model bennett_linkage() {
  return parse(R"toml(format = 1
gravity = [2, -8, 4]
[parameters]
a = 0.41
al = "35 deg"
be = "62 deg"
b = "a*sin(be)/sin(al)"
[[body]]
name = "first"
mass = 1.3
center_of_mass = ["a/2", 0.01, 0]
inertia = [2e-3, 9e-3, 8e-3]
[[body]]
name = "coupler"
mass = 0.8
center_of_mass = ["b/2", 0.02, 0]
inertia = [1e-3, 1e-2, 1.05e-2]
[[body]]
name = "last"
mass = 1
center_of_mass = ["a/2", 0, 0.01]
inertia = [1e-3, 8e-3, 7e-3]
[[joint]]
name = "J1"
type = "revolute"
parent = "ground"
child = "first"
start.turn_z = { keep = "50 deg", keep_speed = 0 }
[[joint]]
name = "J2"
type = "revolute"
parent = { body = "first", point = ["a", 0, 0], axis = [1, 0, 0], angle = "al" }
child = "coupler"
start.turn_z = { guess = "110 deg" }
[[joint]]
name = "J3"
type = "revolute"
parent = { body = "coupler", point = ["b", 0, 0], axis = [1, 0, 0], angle = "be" }
child = "last"
start.turn_z = { guess = "-50 deg" }
[[joint]]
name = "J4"
type = "revolute"
parent = { body = "last", point = ["a", 0, 0], axis = [1, 0, 0], angle = "al" }
child = { body = "ground", sequence = "xyz", angles = ["-be", 0, 0], point = ["-b", 0, 0] }
)toml");
}

/// Off its closed poses such a linkage has a row more, which asks for steps along its motion.
TEST_CASE("An overconstrained linkage comes to rest, though nothing of its reactions is unique", "[analyses]") {
  const AnalysisVerdict rest = judge_statics(bennett_linkage(), kMakers);
  CHECK(rest.wrenches.findings.empty());
  REQUIRE(rest.wrenches.failures.size() == 1);
  CHECK_THAT(rest.wrenches.failures.front(), Catch::Contains("no reaction was judged"));
  CHECK(std::all_of(rest.numbers.begin(), rest.numbers.end(), [](const auto& row) { return row.agrees(); }));
}

/// What its edge permits does not span the places that it can reach: where it rests depends on how it goes there.
TEST_CASE("Where a skate comes to rest is not determined", "[analyses][quick]") {
  const auto skate = [](double turn) {
    return held_at_start(parse(fmt::format(R"toml(format = 1
gravity = [1.3, 0.4, -9.81]
[[body]]
name = "skate"
mass = 2.2
inertia = [0.1, 0.2, 0.15]
center_of_mass = [0.06, 0.01, 0.1]
[[joint]]
name = "edge"
type = "knife_edge"
parent = "ground"
child = "skate"
start.slide_x = {{ keep = 0.1, keep_speed = 0 }}
start.slide_y = {{ keep = 0 }}
start.turn_z = {{ keep = {}, keep_speed = 0 }}
[[line_spring]]
name = "tether"
parent = {{ body = "ground", point = [-0.8, 0.7, 0.1] }}
child = {{ body = "skate", point = [0.15, 0, 0.1] }}
stiffness = 130
free = 0.4
)toml",
                                           turn)));
  };
  const Model held = skate(0.6);
  const Solvers solvers{cartesian::make_solver(held), relative::make_solver(held)};
  const Rests rests = find_rests(held, solvers);
  CHECK_NOTHROW(refuse_undetermined_rest(held, solvers, rests));
  const Model turned = skate(0.61);
  const Equilibrium other = find_equilibrium(held, *solvers[1], both_solvers(turned)[1]->assemble());
  CHECK_THROWS_WITH(
      refuse_undetermined_rest(held, solvers,
                               {{rests.found[0], other}, {rests.states[0], one_sample(other.state, other.evaluation)}}),
      Catch::Contains("the equilibrium is not determined"));
}

TEST_CASE("Modes about an equilibrium are those of a machine at rest, whatever holds it there", "[analyses][quick]") {
  const Model model = parse_model(R"toml(format = 1
[[body]]
name = "blade"
[body.beam]
length = 0.8
section = { width_y = 0.03, width_z = 0.02 }
youngs_modulus = 7e10
density = 2700
support = "cantilever"
modes = { bending_xy = [1, 2] }
[[joint]]
name = "root"
type = "weld"
parent = { body = "ground", point = [0.1, 0.2, 0.3], axis = [1, 2, 0.5], angle = "35 deg" }
child = { body = "blade", node = "first" }
[[load]]
name = "tip"
body = "blade"
node = "last"
force = [3, -40, 11]
)toml",
                                  "blade.toml");
  const AnalysisVerdict modes = judge_linearization(model, kMakers, true);
  CHECK(modes.wrenches.outcome == Outcome::agree);
  CHECK_THAT(modes.text, !Catch::Contains("accelerates"));
}

TEST_CASE("A rest that may point anywhere is judged in the frames of its joints", "[analyses]") {
  const AnalysisVerdict rest = judge_statics(machine_of("neutral", "bicycle"), kMakers);
  INFO(rest.text);
  CHECK(rest.wrenches.outcome == Outcome::agree);
  CHECK(rest.wrenches.judged == 30);
}

}  // namespace
}  // namespace concord::verification
