#include <algorithm>
#include <catch2/catch.hpp>
#include <numbers>
#include <string>

#include "closed_forms.h"
#include "common/error.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/report.h"
#include "compare/equilibrium/equilibrium.h"

/// Analyses of machines in which something is special: a pose, a size, nothing that holds them.
namespace concord::verification {
namespace {

using compare::find_equilibrium;
using compare::held_at_start;
using compare::analyses::AnalysisVerdict;
using compare::analyses::format_analysis;
using compare::analyses::judge_inverse;
using compare::analyses::judge_linearization;
using compare::analyses::judge_statics;
using compare::analyses::linearize;

TEST_CASE("A rhombus folded flat is refused as a singular pose, not answered and not a crash", "[analyses][quick]") {
  // Hinges at 0 and 0.31 on ground and arms of 0.27 along the same line: it may unfold in two ways.
  const Model model = held_at_start(parse(R"toml(format = 1
gravity = [0.7, -9.6, 1.4]
[[body]]
name = "near"
mass = 1.2
center_of_mass = [0.06, 0.02, 0.01]
inertia = [0.012, 0.014, 0.013, 0.0004, -0.0002, 0.0006]
[[body]]
name = "bar"
mass = 0.7
center_of_mass = [0.15, -0.02, 0.03]
inertia = [0.01, 0.012, 0.011, 0.0005, -0.0003, 0.0007]
[[body]]
name = "far"
mass = 1.1
center_of_mass = [0.12, 0.01, -0.02]
inertia = [0.011, 0.013, 0.012, 0.0005, -0.0003, 0.0007]
[[joint]]
name = "A"
type = "revolute"
parent = "ground"
child = "near"
start.turn_z = { keep = 0, keep_speed = 0 }
[[joint]]
name = "B"
type = "revolute"
parent = { body = "near", point = [0.27, 0, 0] }
child = "bar"
start.turn_z = { guess = 0 }
[[joint]]
name = "C"
type = "revolute"
parent = { body = "bar", point = [0.31, 0, 0] }
child = { body = "far", point = [0.27, 0, 0] }
start.turn_z = { keep = 0, keep_speed = 0 }
[[joint]]
name = "D"
type = "revolute"
parent = { body = "ground", point = [0.31, 0, 0] }
child = "far"
start.turn_z = { guess = 0 }
)toml"));
  for (const auto& solver : both_solvers(model)) {
    CHECK_THROWS_WITH(find_equilibrium(model, *solver), Catch::Contains("singular"));
    const State start = solver->assemble();
    CHECK_THROWS_WITH(linearize(model, *solver, start), Catch::Contains("singular"));
  }
}

TEST_CASE("A beam that nothing holds has twelve free modes and then those of its bending", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
[[body]]
name = "needle"
[body.beam]
length = 0.17
elements = 24
section = { width_y = 0.004, width_z = 0.007 }
youngs_modulus = 1.1e11
density = 8400
support = "free_free"
modes = { bending_xy = [1, 2], bending_xz = [1] }
[[joint]]
name = "flight"
type = "free"
parent = "ground"
child = { body = "needle", node = "7" }
start.slide_x = { keep = 0.2, keep_speed = 0 }
start.slide_y = { keep = 0, keep_speed = 0 }
start.slide_z = { keep = -0.1, keep_speed = 0 }
start.ball = { keep = { axis = [1, 2, 0], angle = 0 }, keep_speed = [0, 0, 0] }
)toml");
  const AnalysisVerdict result = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, result, true));
  CHECK(result.wrenches.findings.empty());
  // (b L)^2 sqrt(E I / (rho A)) / L^2, b L = 4.73004074 and 7.85320462.
  const double by_width = std::sqrt(1.1e11 / 8400.0 / 12.0) / (0.17 * 0.17);
  const double exact[] = {22.3732854 * 0.004 * by_width, 22.3732854 * 0.007 * by_width, 61.6728229 * 0.004 * by_width};
  for (const auto& found : result.linearizations) {
    REQUIRE(found->modes.size() == 15);
    for (int k = 0; k < 12; ++k) CHECK(found->modes[k].is_free);
    for (int k = 0; k < 3; ++k) {
      CHECK_FALSE(found->modes[12 + k].is_free);
      CHECK(found->modes[12 + k].eigenvalue.imag() == Approx(exact[k]).epsilon(2e-5));
    }
  }
}

/// A beam that floats with a strain, beside a rod on a hinge; nothing else acts.
std::string strained_beside_a_rod(const char* modes, const char* strain, double turned) {
  return fmt::format(R"toml(format = 1
[[body]]
name = "beam"
start.a = {1}
[body.beam]
length = 0.9
elements = 20
section = {{ diameter = 0.027 }}
youngs_modulus = 7.2e10
density = 2750
poissons_ratio = 0.3
support = "free_free"
modes = {{ {0} }}
[[body]]
name = "rod"
mass = 1.3
inertia = [6e-5, 0.008, 0.00802]
center_of_mass = [0.16, 0.01, 0]
[[joint]]
name = "flight"
type = "free"
parent = "ground"
child = {{ body = "beam", node = "first" }}
start.slide_x = {{ keep = 0, keep_speed = 0 }}
start.slide_y = {{ keep = 0.1, keep_speed = 0 }}
start.slide_z = {{ keep = 0, keep_speed = 0 }}
start.ball = {{ keep = {{ axis = [0.2, 0.5, 1], angle = {2} }}, keep_speed = [0, 0, 0] }}
[[joint]]
name = "hinge"
type = "revolute"
parent = {{ body = "ground", point = [0, 1, 0] }}
child = "rod"
start.turn_z = {{ keep = 0.2, keep_speed = 0 }}
)toml",
                     modes, strain, turned);
}

TEST_CASE("A strained beam that floats relaxes to a rest in which nothing acts", "[analyses][quick]") {
  const auto& [modes, strain] = GENERATE(table<const char*, const char*>(
      {{"axial = [1]", "[1.1e-4]"}, {"bending_xy = [1]", "[1.1e-4]"}, {"torsion = [1]", "[2e-3]"}}));
  const double turned = GENERATE(0.0, 0.4);
  CAPTURE(modes, turned);
  const Model model = parse(strained_beside_a_rod(modes, strain, turned));
  const AnalysisVerdict result = judge_statics(model, kMakers);
  INFO(format_analysis(model, result, true));
  CHECK(result.wrenches.findings.empty());
  CHECK(result.wrenches.failures.empty());
  for (const auto& make : {cartesian::make_solver, relative::make_solver}) {
    const auto found = find_equilibrium(model, *make(held_at_start(model)));
    CHECK(found.free.size() == 7);
    CHECK(std::abs(found.state.bodies[1].a(0)) < 1e-12);
  }
}

TEST_CASE("Analyses say that a column is pressed beyond what its model can tell", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
[[body]]
name = "column"
[body.beam]
length = 1.1
section = { diameter = 0.021 }
youngs_modulus = 2.1e11
density = 7800
support = "cantilever"
modes = { bending_xy = [1, 2], bending_xz = [1, 2] }
[[joint]]
name = "base"
type = "weld"
parent = "ground"
child = { body = "column", node = "first" }
[[load]]
name = "press"
body = "column"
node = "last"
force = [-8000, 0, 0]
)toml");
  // Of the lowest mode of a cantilever: integrals of w'^2 and of w''^2 over its length, 4.6478 / L and 12.3624 / L^3.
  const double elastic = 2.1e11 * std::numbers::pi / 64.0 * std::pow(0.021, 4) * 12.3624 / (1.1 * 1.1);
  for (const AnalysisVerdict& result : {judge_statics(model, kMakers), judge_linearization(model, kMakers, false)}) {
    INFO(format_analysis(model, result, true));
    CHECK(result.text.find("note: geometric stiffness, which no model has: on body column") != std::string::npos);
    const auto& ratios = result.wrenches.geometric_stiffness;
    REQUIRE(ratios);
    for (const auto& ratio : *ratios) CHECK(ratio.lowest == Approx(-8000.0 * 4.6478 / elastic).epsilon(1e-3));
  }
}

constexpr double kBladeLength = 1.2;
constexpr double kBladeSpeed = 31.0;
constexpr double kBladeBending = 7e10 * 5e-9;   // E I, N m2
constexpr double kBladeMass = 2700.0 * 1e-3;    // of its length, kg/m
constexpr double kTipMass = 0.7;                // kg
constexpr double kBladeModes = 12.3624;         // (1.8751)^4
constexpr double kSouthwell = 1.1933;           // of a rotating cantilever
constexpr double kSlopesOfCantilever = 4.6478;  // integral of w'^2 of its first mode, over that of w^2

/// A blade, askew in its body and tilted, clamped to a hinge; `axial`: its axial modes; `tip`: what stands at its tip;
/// `spin`: the lines of the hinge that say how it turns, about z of the hinge.
Model spinning_blade(const char* axial, const char* tip, const char* spin) {
  return parse(fmt::format(R"toml(format = 1
[[body]]
name = "blade"
[body.beam]
first_end = [0.1, -0.2, 0.05]
x = [0.6, 0, 0.8]
z = [0, 1, 0]
length = 1.2
section = {{ area = 1e-3, second_moment_y = 5e-9, second_moment_z = 5e-9, torsion_constant = 1e-8 }}
youngs_modulus = 7e10
shear_modulus = 2.6e10
density = 2700
support = "cantilever"
modes = {{ bending_xy = [1], bending_xz = [1], axial = {} }}
[[joint]]
name = "root"
type = "revolute"
parent = {{ body = "ground", point = [0.3, 0.1, 0.2], x = [0.8, -0.6, 0], z = [0.48, 0.64, 0.6] }}
child = {{ body = "blade", node = "first", x = [0.6, 0, 0.8], z = [0, 1, 0] }}
{}
{})toml",
                           axial, spin, tip));
}

constexpr const char* kTip = R"toml([[body]]
name = "tip"
mass = 0.7
inertia = [1e-9, 1e-9, 1e-9]
[[joint]]
name = "end"
type = "weld"
parent = { body = "blade", node = "last" }
child = "tip"
)toml";
constexpr const char* kDrivenSpin = "drive.turn_z = { law = \"polynomial\", coefficients = [0.3, 31] }";
constexpr const char* kKeptSpin = "start.turn_z = { keep = 0.3, keep_speed = 31 }";

TEST_CASE("Analyses tell by how much a spinning blade is stiffened, however it could stretch, as Southwell does",
          "[analyses][quick]") {
  const auto axial = GENERATE(as<std::string>{}, "[]", "[1]", "[1, 2, 3]");
  const double at_tip = GENERATE(0.0, kTipMass);
  CAPTURE(axial, at_tip);
  const double elastic = kBladeBending * kBladeModes;
  const double span = std::pow(kBladeLength, 3);
  const double stiffened = kBladeSpeed * kBladeSpeed * span / elastic *
                           (kSouthwell * kBladeMass * kBladeLength + kSlopesOfCantilever * at_tip);
  const char* tip = at_tip > 0.0 ? kTip : "";
  const Model driven = spinning_blade(axial.c_str(), tip, kDrivenSpin);
  const Model kept = spinning_blade(axial.c_str(), tip, kKeptSpin);
  for (const AnalysisVerdict& result : {judge_linearization(driven, kMakers, false),
                                        judge_linearization(kept, kMakers, false), judge_inverse(kept, kMakers, {})}) {
    INFO(format_analysis(kept, result, true));
    CHECK(result.wrenches.findings.empty());
    CHECK(result.text.find("note: geometric stiffness, which no model has: on body blade") != std::string::npos);
    REQUIRE(result.wrenches.geometric_stiffness);
    for (const auto& ratio : *result.wrenches.geometric_stiffness) {
      CHECK(ratio.lowest == Approx(stiffened).epsilon(1e-3));
      CHECK(ratio.highest == ratio.lowest);
    }
  }
}

TEST_CASE("With the stiffness that it is told to lack, a blade flaps at Southwell's frequency", "[analyses][quick]") {
  const Model model = spinning_blade("[1, 2, 3]", "", kDrivenSpin);
  const AnalysisVerdict found = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, found, true));
  REQUIRE(found.wrenches.geometric_stiffness);
  const auto& ratios = *found.wrenches.geometric_stiffness;
  REQUIRE(ratios.size() == 2);
  const double at_rest = kBladeBending * kBladeModes / (kBladeMass * std::pow(kBladeLength, 4));
  // In the plane it leaves: without its stiffening the centrifugal force is the stronger one there.
  const auto& modes = found.linearizations[0]->modes;
  const auto slowest = std::find_if(modes.begin(), modes.end(), [](const auto& mode) { return mode.oscillates(); });
  REQUIRE(slowest != modes.end());
  const double flap = std::norm(slowest->eigenvalue);
  CHECK(flap == Approx(at_rest).epsilon(1e-3));
  CHECK(flap * (1.0 + ratios[1].highest) == Approx(at_rest + kSouthwell * kBladeSpeed * kBladeSpeed).epsilon(1e-3));
}

TEST_CASE("Nothing is told of blades without axial forces", "[analyses][quick]") {
  const auto is_silent = [](const AnalysisVerdict& result) {
    return result.text.find("geometric stiffness") == std::string::npos;
  };
  const Model still = spinning_blade("[1, 2, 3]", kTip, "start.turn_z = { keep = 0.3, keep_speed = 0 }");
  CHECK(is_silent(judge_linearization(still, kMakers, false)));
  CHECK(is_silent(judge_inverse(still, kMakers, {})));
  // Statics and equilibria hold drivers: nothing spins.
  const Model driven = spinning_blade("[1, 2, 3]", kTip, kDrivenSpin);
  CHECK(is_silent(judge_statics(driven, kMakers)));
  CHECK(is_silent(judge_linearization(driven, kMakers, true)));
}

/// A beam of twenty elements with a hinge at its middle, or held there.
Model held_at_its_middle(const char* joint, const char* support, const char* modes) {
  return parse(fmt::format(R"toml(format = 1
[[body]]
name = "beam"
[body.beam]
length = 1.3
elements = 20
section = {{ diameter = 0.022 }}
youngs_modulus = 2.8e9
density = 1150
poissons_ratio = 0.3
support = "{}"
modes = {{ {} }}
[[joint]]
name = "middle"
{}
parent = {{ body = "ground", point = [0.2, 0.1, -0.3], x = [0.6, 0.8, 0], z = [0, 0, 1] }}
child = {{ body = "beam", node = "10", x = [1, 0, 0], z = [0, 1, 0] }}
)toml",
                           support, modes, joint));
}

constexpr const char* kSprungHinge = R"toml(type = "revolute"
start.turn_z = { keep = 0.1, keep_speed = 0 }
spring.turn_z = { stiffness = 130, free = 0.1 })toml";

TEST_CASE("A joint where a mode has a node of vibration feels nothing of it", "[analyses][quick]") {
  const auto& [joint, support, modes] = GENERATE(table<const char*, const char*, const char*>(
      {{kSprungHinge, "simply_supported", "torsion = [2]"},
       {kSprungHinge, "craig_bampton", "axial = [1, 2]"},
       {"type = \"weld\"", "craig_bampton", "axial = [1, 2]"},
       {"type = \"weld\"", "free_free", "axial = [1, 2], bending_xz = [1]"}}));
  CAPTURE(joint, support, modes);
  const Model model = held_at_its_middle(joint, support, modes);
  const AnalysisVerdict result = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, result, true));
  CHECK(result.wrenches.findings.empty());
  if (joint != kSprungHinge) return;
  double inertia = 0.0;
  const ModalData& modal = *model.bodies[1].modal;
  for (const MassPoint& point : modal.mass_points) {
    inertia += point.mass * (point.s0_L - modal.nodes[10].s0_L).squaredNorm();
  }
  for (const auto& found : result.linearizations) {
    CHECK(found->modes.front().eigenvalue.imag() == Approx(std::sqrt(130.0 / inertia)).epsilon(1e-3));
  }
}

/// Factors of lengths, masses and times.
struct Size {
  double length;
  double mass;
  double time;
};

/// A crank with a spring in its hinge; on a rail of it slides a flexible wand against a spring and a damper.
std::string wand_on_a_crank(const Size& size) {
  const double force = size.mass * size.length / (size.time * size.time);
  return fmt::format(
      R"toml(format = 1
gravity = [{:.16e}, {:.16e}, 0]
[[body]]
name = "crank"
mass = {:.16e}
center_of_mass = [{:.16e}, {:.16e}, {:.16e}]
inertia = [{:.16e}, {:.16e}, {:.16e}]
[[body]]
name = "wand"
[body.beam]
length = {:.16e}
elements = 6
section = {{ diameter = {:.16e} }}
youngs_modulus = {:.16e}
poissons_ratio = 0.3
density = {:.16e}
support = "cantilever"
modes = {{ bending_xy = [1], bending_xz = [1] }}
damping_ratio = 0.02
[[joint]]
name = "hinge"
type = "revolute"
parent = {{ body = "ground", axis = [1, 1, 0], angle = 0.5 }}
child = "crank"
start.turn_z = {{ keep = 0.6, keep_speed = {:.16e} }}
spring.turn_z = {{ stiffness = {:.16e}, damping = {:.16e} }}
[[joint]]
name = "rail"
type = "translational"
parent = {{ body = "crank", point = [0, {:.16e}, 0], x = [0, 1, 0], z = [1, 0, 0.4] }}
child = {{ body = "wand", node = "first" }}
start.slide_z = {{ keep = {:.16e}, keep_speed = {:.16e} }}
spring.slide_z = {{ stiffness = {:.16e}, damping = {:.16e} }}
)toml",
      -3.0 * force / size.mass, -8.8 * force / size.mass, 1.9 * size.mass, 0.04 * size.length, 0.03 * size.length,
      -0.2 * size.length, 0.05 * force * size.time * size.time * size.length,
      0.06 * force * size.time * size.time * size.length, 0.03 * force * size.time * size.time * size.length,
      0.5 * size.length, 0.012 * size.length, 2.2e10 * force / (size.length * size.length),
      2400.0 * size.mass / std::pow(size.length, 3), 1.5 / size.time, 4.0 * force * size.length,
      0.2 * force * size.length * size.time, 0.11 * size.length, 0.04 * size.length, -0.2 * size.length / size.time,
      250.0 * force / size.length, 1.4 * force * size.time / size.length);
}

TEST_CASE("Analyses say the same of a machine of any size", "[analyses]") {
  const Size size = GENERATE(Size{1, 1, 1}, Size{1e-3, 1, 1}, Size{1e6, 1, 1}, Size{1, 1e-6, 1}, Size{1, 1e6, 1},
                             Size{1, 1, 1e-6}, Size{1, 1, 1e6}, Size{1e-3, 1e-6, 1e6}, Size{1e6, 1e-6, 1e-6});
  const Model model = parse(wand_on_a_crank(size));
  const AnalysisVerdict statics = judge_statics(model, kMakers);
  INFO(format_analysis(model, statics, true));
  CHECK(statics.wrenches.outcome == compare::Outcome::agree);
  const AnalysisVerdict start = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, start, true));
  CHECK(start.wrenches.outcome == compare::Outcome::agree);
  const AnalysisVerdict hanging = judge_linearization(model, kMakers, true);
  INFO(format_analysis(model, hanging, true));
  CHECK(hanging.wrenches.outcome == compare::Outcome::agree);
  const AnalysisVerdict inverse = judge_inverse(model, kMakers, {});
  INFO(format_analysis(model, inverse, true));
  CHECK(inverse.wrenches.outcome == compare::Outcome::agree);
  // The same modes, in the machine's own time.
  const Model one = parse(wand_on_a_crank({1, 1, 1}));
  const auto solver = relative::make_solver(one);
  const auto of_one = linearize(one, *solver, solver->assemble());
  REQUIRE(start.linearizations[1]->modes.size() == of_one.modes.size());
  for (std::size_t k = 0; k < of_one.modes.size(); ++k) {
    const auto scaled = start.linearizations[1]->modes[k].eigenvalue * size.time;
    CHECK(std::abs(scaled - of_one.modes[k].eigenvalue) < 1e-7 * std::abs(of_one.modes[k].eigenvalue));
  }
}

}  // namespace
}  // namespace concord::verification
