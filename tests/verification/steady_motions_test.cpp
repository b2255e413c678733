#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <regex>

#include "closed_forms.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/report.h"

/// Small motions about motions that go on for ever: rotors, turntables, conical pendulums.
namespace concord::verification {
namespace {

using compare::analyses::AnalysisVerdict;
using compare::analyses::format_analysis;
using compare::analyses::judge_linearization;

const Mat3 kTurnedWorld = rotation_about(Vec3(Vec3(2.0, 1.0, -0.6).normalized()), 1.1);

/// Frequencies [rad/s] of the motions that oscillate, lowest first, by both solvers, which must agree.
std::vector<double> frequencies_of(const std::string& text, std::size_t free) {
  const Model model = turn_world(parse(text), kTurnedWorld);
  const AnalysisVerdict result = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, result, true));
  CHECK(result.wrenches.outcome == compare::Outcome::agree);
  CHECK(result.text.find("note") == std::string::npos);
  std::vector<double> found;
  std::size_t n_free = 0;
  for (const auto& mode : result.linearizations[1]->modes) {
    if (mode.is_free) ++n_free;
    if (mode.oscillates()) found.push_back(mode.eigenvalue.imag());
    CHECK(std::abs(mode.eigenvalue.real()) < 1e-9 * std::abs(mode.eigenvalue) + 1e-12);
  }
  CHECK(n_free == free);
  return found;
}

bool holds(const std::vector<double>& found, double frequency) {
  return std::any_of(found.begin(), found.end(),
                     [&](double one) { return std::abs(one - frequency) < 1e-8 * frequency; });
}

/// A housing of 2 kg on a bushing, in it an axisymmetric rotor of 5 kg; `rotor`: how it sits and turns there.
std::string rotor_on_bushing(const std::string& rotor) {
  return R"toml(format = 1
[[body]]
name = "rotor"
mass = 5
center_of_mass = [0, 0, 0]
inertia = [0.02, 0.02, 0.035]
[[body]]
name = "housing"
mass = 2
center_of_mass = [0, 0, 0]
inertia = [0.01, 0.01, 0.012]
[[bushing]]
name = "mount"
parent = "ground"
child = "housing"
stiffness = [1e4, 1e4, 2e4, 100, 100, 150]
)toml" + rotor;
}

const std::string kFreeHousing = R"toml([[joint]]
name = "housing"
type = "free"
parent = "ground"
child = "housing"
start.slide_x = { keep = 0, keep_speed = 0 }
start.slide_y = { keep = 0, keep_speed = 0 }
start.slide_z = { keep = 0, keep_speed = 0 }
start.ball = { keep = { axis = [1, 0, 0], angle = 0 }, keep_speed = [0, 0, 0] }
)toml";

/// A w^2 -+ C W w - k = 0: both whirls of a rotor whose support weighs nothing more than A.
void check_whirl(const std::vector<double>& found, double A, double C, double k, double spin) {
  const double root = std::sqrt(C * spin * C * spin + 4.0 * A * k);
  CHECK(holds(found, (C * spin + root) / (2.0 * A)));
  CHECK(holds(found, (root - C * spin) / (2.0 * A)));
}

TEST_CASE("A rotor in a housing on a bushing whirls forward and backward by its gyroscopic torque",
          "[analyses][quick]") {
  const std::string spin = GENERATE("drive.turn_z = { law = \"constant_speed\", speed = 200 }",
                                    "start.turn_z = { keep = 0.4, keep_speed = 200 }");
  const bool is_kept = spin.find("keep") != std::string::npos;
  const bool is_reversed = GENERATE(false, true);
  const auto found =
      frequencies_of(rotor_on_bushing(kFreeHousing) +
                         fmt::format("[[joint]]\nname = \"spin\"\ntype = \"revolute\"\nparent = "
                                     "\"{}\"\nchild = \"{}\"\n{}\n",
                                     is_reversed ? "rotor" : "housing", is_reversed ? "housing" : "rotor", spin),
                     is_kept ? 2 : 0);
  check_whirl(found, 0.03, 0.035, 100.0, 200.0);
}

TEST_CASE("A rotor whose spin is part of a ball whirls like one on a shaft", "[analyses][quick]") {
  const bool is_reversed = GENERATE(false, true);
  const auto found = frequencies_of(fmt::format(R"toml(format = 1
[[body]]
name = "rotor"
mass = 5
center_of_mass = [0, 0, 0]
inertia = [0.02, 0.02, 0.035]
[[bushing]]
name = "mount"
parent = "ground"
child = "rotor"
stiffness = [1e4, 1e4, 2e4, 100, 100, 0]
[[joint]]
name = "rotor"
type = "spherical"
parent = "{}"
child = "{}"
start.ball = {{ keep = {{ axis = [1, 0, 0], angle = 0 }}, keep_speed = [0, 0, 30] }}
)toml",
                                                is_reversed ? "rotor" : "ground", is_reversed ? "ground" : "rotor"),
                                    2);
  check_whirl(found, 0.02, 0.035, 100.0, 30.0);
}

std::string gyroscope_in_gimbal(double spin) {
  return R"toml(format = 1
[[body]]
name = "rotor"
mass = 5
center_of_mass = [0, 0, 0]
inertia = [0.02, 0.02, 0.035]
[[body]]
name = "gimbal"
mass = 2
center_of_mass = [0, 0, 0]
inertia = [0.01, 0.01, 0.01]
[[joint]]
name = "gimbal"
type = "universal"
parent = "ground"
child = "gimbal"
start.turn_x = { keep = 0, keep_speed = 0 }
start.turn_y = { keep = 0, keep_speed = 0 }
spring.turn_x = { stiffness = 100 }
spring.turn_y = { stiffness = 100 }
[[joint]]
name = "spin"
type = "revolute"
parent = "gimbal"
child = "rotor"
start.turn_z = { keep = 0, keep_speed = )toml" +
         fmt::format("{:g} }}\n", spin);
}

TEST_CASE("A gyroscope on two springs in a gimbal nutates and precesses", "[analyses][quick]") {
  check_whirl(frequencies_of(gyroscope_in_gimbal(200.0), 2), 0.03, 0.035, 100.0, 200.0);
}

// Detects slow modes of fast rotors that are taken for free, because their frequency is far below the root of what
// differences resolve of a stiffness.
TEST_CASE("A gyroscope precesses by its springs however fast it spins", "[analyses][quick]") {
  for (const double spin : {1e4, 1e5}) {
    INFO(spin);
    const double gyroscopic = 0.035 * spin;
    const double slow = 2.0 * 100.0 / (gyroscopic + std::sqrt(gyroscopic * gyroscopic + 4.0 * 0.03 * 100.0));
    const Model model = turn_world(parse(gyroscope_in_gimbal(spin)), kTurnedWorld);
    const AnalysisVerdict found = judge_linearization(model, kMakers, false);
    INFO(format_analysis(model, found, true));
    CHECK(found.wrenches.outcome == compare::Outcome::agree);
    // Of so slow a rate two to four digits are resolved, as the pose has it: that these are few may be said, and
    // nothing else.
    CHECK(std::regex_replace(found.text, std::regex("note: fewer than 3 digits are resolved of the eigenvalues"), "")
              .find("note") == std::string::npos);
    for (const auto& linearization : found.linearizations) {
      const auto& modes = linearization->modes;
      CHECK(std::count_if(modes.begin(), modes.end(), [](const auto& mode) { return mode.is_free; }) == 2);
      CHECK(std::any_of(modes.begin(), modes.end(), [&](const auto& mode) {
        return std::abs(mode.eigenvalue - std::complex<double>(0.0, slow)) < 1e-5 * slow;
      }));
    }
  }
}

/// 0.5 kg on a radial spring of 100 N/m, free at 0.1 m, 0.2 m out on an arm that turns at 10 rad/s.
std::string slider_on_arm(const std::string& turn) {
  return fmt::format(R"toml(format = 1
[[body]]
name = "arm"
mass = 1
center_of_mass = [0, 0, 0]
inertia = [0.01, 0.01, 0.01]
[[body]]
name = "slider"
mass = 0.5
center_of_mass = [0, 0, 0]
inertia = [1e-4, 1e-4, 1e-4]
[[joint]]
name = "arm"
type = "revolute"
parent = "ground"
child = "arm"
{}
[[joint]]
name = "rail"
type = "translational"
parent = {{ body = "arm", axis = [0, 1, 0], angle = "90 deg" }}
child = {{ body = "slider", axis = [0, 1, 0], angle = "90 deg" }}
start.slide_z = {{ keep = 0.2, keep_speed = 0 }}
spring.slide_z = {{ stiffness = 100, free = 0.1 }}
)toml",
                     turn);
}

TEST_CASE("A slider on a turning arm swings at the root of k/m - W^2", "[analyses][quick]") {
  const auto found = frequencies_of(slider_on_arm("drive.turn_z = { law = \"constant_speed\", speed = 10 }"), 0);
  REQUIRE(found.size() == 1);
  CHECK(found[0] == Approx(10.0).epsilon(1e-9));
}

TEST_CASE("A slider on an arm that turns freely swings as its angular momentum stays", "[analyses][quick]") {
  const auto found = frequencies_of(slider_on_arm("start.turn_z = { keep = 0.3, keep_speed = 10 }"), 2);
  REQUIRE(found.size() == 1);
  const double I = 0.0101 + 0.5 * 0.2 * 0.2;
  CHECK(found[0] == Approx(std::sqrt(100.0 + 4.0 * 100.0 * 0.5 * 0.04 / I)).epsilon(1e-8));
}

TEST_CASE("A conical pendulum driven round nods at W sin(theta)", "[analyses][quick]") {
  const double cosine = 9.81 / (64.0 * 0.4);
  const auto found = frequencies_of(fmt::format(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "shaft"
mass = 1
center_of_mass = [0, 0, 0]
inertia = [0.01, 0.01, 0.01]
[[body]]
name = "bob"
mass = 1
center_of_mass = [0, 0, -0.4]
inertia = [0, 0, 0]
[[joint]]
name = "shaft"
type = "revolute"
parent = "ground"
child = "shaft"
drive.turn_z = {{ law = "constant_speed", speed = 8 }}
[[joint]]
name = "hinge"
type = "revolute"
parent = {{ body = "shaft", x = [0, 0, 1], z = [0, 1, 0] }}
child = {{ body = "bob", x = [0, 0, 1], z = [0, 1, 0] }}
start.turn_z = {{ keep = {:.17g}, keep_speed = 0 }}
)toml",
                                                -std::acos(cosine)),
                                    0);
  REQUIRE(found.size() == 1);
  CHECK(found[0] == Approx(8.0 * std::sqrt(1.0 - cosine * cosine)).epsilon(1e-9));
}

/// The same pendulum on one universal joint whose outer axis is the vertical: its inner angle nods, the outer one
/// turns.
TEST_CASE("A conical pendulum on a universal joint nods at W sin(theta)", "[analyses][quick]") {
  const double cosine = 9.81 / (64.0 * 0.4);
  const auto found = frequencies_of(fmt::format(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "bob"
mass = 1
center_of_mass = [0, 0, -0.4]
inertia = [0, 0, 0]
[[joint]]
name = "cross"
type = "universal"
parent = {{ body = "ground", x = [0, 0, 1], z = [1, 0, 0] }}
child = {{ body = "bob", x = [0, 0, 1], z = [1, 0, 0] }}
drive.turn_x = {{ law = "constant_speed", speed = 8 }}
start.turn_y = {{ keep = {:.17g}, keep_speed = 0 }}
)toml",
                                                std::acos(cosine)),
                                    0);
  REQUIRE(found.size() == 1);
  CHECK(found[0] == Approx(8.0 * std::sqrt(1.0 - cosine * cosine)).epsilon(1e-9));
}

TEST_CASE("A rotor with two unequal inertias across its axis is steady if what carries it is alike all around",
          "[analyses][quick]") {
  std::string text = rotor_on_bushing(kFreeHousing) + R"toml([[joint]]
name = "spin"
type = "revolute"
parent = "housing"
child = "rotor"
drive.turn_z = { law = "constant_speed", speed = 200 }
)toml";
  text.replace(text.find("0.02, 0.02"), 10, "0.02, 0.03");
  const AnalysisVerdict in_its_axes = judge_linearization(parse(text), kMakers, false);
  CHECK(in_its_axes.wrenches.outcome == compare::Outcome::agree);
  CHECK(in_its_axes.text.find("steady in axes that turn at (0, 0, 200) rad/s; deviations of all bodies") !=
        std::string::npos);
  text.replace(text.find("0.01, 0.01, 0.012"), 17, "0.01, 0.015, 0.012");
  const AnalysisVerdict result = judge_linearization(parse(text), kMakers, false);
  CHECK(result.wrenches.outcome == compare::Outcome::agree);
  CHECK(result.text.find("the motion is not steady") != std::string::npos);
}

/// Frequencies [rad/s] of the motions that oscillate, lowest first, by both solvers, which must agree; `note` must be
/// in what they say of the axes in which the machine deviates.
std::vector<double> frequencies_in_turning_axes(const std::string& text, const std::string& note) {
  const Model model = turn_world(parse(text), kTurnedWorld);
  const AnalysisVerdict result = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, result, true));
  CHECK(result.wrenches.outcome == compare::Outcome::agree);
  CHECK(result.text.find(note) != std::string::npos);
  std::vector<double> found;
  for (const auto& mode : result.linearizations[1]->modes) {
    if (mode.oscillates()) found.push_back(mode.eigenvalue.imag());
    CHECK(std::abs(mode.eigenvalue.real()) < 1e-9 * std::abs(mode.eigenvalue) + 1e-9);
  }
  return found;
}

TEST_CASE("A disc that tilts on a rotor in a housing that tilts whirls as their two gyroscopic equations say",
          "[analyses][quick]") {
  constexpr double kSpin = 70.0;
  const std::string text = fmt::format(R"toml(format = 1
[[body]]
name = "housing"
mass = 2
inertia = [0.06, 0.047, 0.047]
[[body]]
name = "rotor"
mass = 1
inertia = [0.003, 0.002, 0.002]
[[body]]
name = "disc"
mass = 5
inertia = [0.05, 0.027, 0.027]
[[joint]]
name = "tilt"
type = "universal"
both = {{ x = [0, 1, 0], z = [1, 0, 0] }}
parent = "ground"
child = "housing"
start = {{ turn_x = {{ keep = 0, keep_speed = 0 }}, turn_y = {{ keep = 0, keep_speed = 0 }} }}
spring = {{ turn_x = {{ stiffness = 210 }}, turn_y = {{ stiffness = 210 }} }}
[[joint]]
name = "spin"
type = "revolute"
both = {{ y = [0, 1, 0], z = [1, 0, 0] }}
parent = "housing"
child = "rotor"
start.turn_z = {{ keep = 0, keep_speed = {} }}
[[joint]]
name = "flexure"
type = "universal"
both = {{ x = [0, 1, 0], z = [1, 0, 0] }}
parent = "rotor"
child = "disc"
start = {{ turn_x = {{ keep = 0, keep_speed = 0 }}, turn_y = {{ keep = 0, keep_speed = 0 }} }}
spring = {{ turn_x = {{ stiffness = 330 }}, turn_y = {{ stiffness = 330 }} }}
)toml",
                                       kSpin);
  const std::vector<double> found = frequencies_in_turning_axes(text, "deviations of all bodies");
  REQUIRE(found.size() == 4);
  // phi, psi: tilts of housing and disc as complex numbers in axes at rest, exp(i w t):
  // (-A w^2 + C W w + k + k_f) phi = k_f psi, (-A_d w^2 + C_d W w + k_f) psi = k_f phi.
  const auto open = [&](double w) {
    const double carrier = -(0.047 + 0.002) * w * w + 0.003 * kSpin * w + 210.0 + 330.0;
    const double disc = -0.027 * w * w + 0.05 * kSpin * w + 330.0;
    return std::abs(carrier * disc - 330.0 * 330.0) / (330.0 * 330.0 + std::abs(carrier * disc) + w * w);
  };
  for (const double frequency : found) {
    CAPTURE(frequency);
    CHECK(std::min(open(kSpin + frequency), open(kSpin - frequency)) < 1e-7);
  }
}

/// A disc in the middle of a flexible shaft, which a universal joint and a ball on a slide carry; `eccentricity` [m].
std::string jeffcott_rotor(double spin, double eccentricity) {
  return fmt::format(R"toml(format = 1
[[body]]
name = "shaft"
[body.beam]
length = 0.9
elements = 20
section = {{ diameter = 0.018 }}
youngs_modulus = 2.1e11
poissons_ratio = 0.3
density = 7800
support = "simply_supported"
modes = {{ bending_xy = [1, 3], bending_xz = [1, 3] }}
[[body]]
name = "disc"
mass = 4
center_of_mass = [0, {1}, 0]
inertia = [0.04, 0.021, 0.021]
[[body]]
name = "yoke"
mass = 1e-6
inertia = [1e-9, 1e-9, 1e-9]
[[body]]
name = "sleeve"
mass = 0.001
inertia = [1e-6, 1e-6, 1e-6]
[[joint]]
name = "bearing"
type = "universal"
both = {{ x = [0, 1, 0], z = [1, 0, 0] }}
parent = "ground"
child = "yoke"
start.turn_x = {{ guess = 0 }}
[[joint]]
name = "spin"
type = "revolute"
parent = {{ body = "yoke", y = [0, 1, 0], z = [1, 0, 0] }}
child = {{ body = "shaft", node = "first", y = [0, 1, 0], z = [1, 0, 0] }}
start.turn_z = {{ keep = 0, keep_speed = {0} }}
[[joint]]
name = "slide"
type = "translational"
parent = {{ body = "ground", point = [0.9, 0, 0], y = [0, 1, 0], z = [1, 0, 0] }}
child = {{ body = "sleeve", y = [0, 1, 0], z = [1, 0, 0] }}
[[joint]]
name = "ball"
type = "spherical"
parent = "sleeve"
child = {{ body = "shaft", node = "last" }}
[[joint]]
name = "seat"
type = "weld"
parent = {{ body = "shaft", node = "10" }}
child = "disc"
)toml",
                     spin, eccentricity);
}

TEST_CASE("A Jeffcott rotor has its frequencies at rest, less and more by its spin, in axes that turn with it",
          "[analyses][quick]") {
  const std::vector<double> at_rest = frequencies_in_turning_axes(jeffcott_rotor(0.0, 0.0), "");
  REQUIRE(at_rest.size() == 4);
  const std::vector<double> found = frequencies_in_turning_axes(jeffcott_rotor(55.0, 0.0), "steady in axes that turn");
  REQUIRE(found.size() == 4);
  for (const int k : {0, 2}) {
    CHECK(found[k] == Approx(at_rest[k] - 55.0).epsilon(1e-6));
    CHECK(found[k + 1] == Approx(at_rest[k] + 55.0).epsilon(1e-6));
  }
}

TEST_CASE("An unbalance of a micrometre changes the frequencies of a rotor by as little", "[analyses][quick]") {
  const std::vector<double> balanced =
      frequencies_in_turning_axes(jeffcott_rotor(55.0, 0.0), "steady in axes that turn");
  const std::vector<double> found =
      frequencies_in_turning_axes(jeffcott_rotor(55.0, 1e-6), "its matrices do not change, in axes");
  REQUIRE(found.size() == balanced.size());
  for (std::size_t k = 0; k < found.size(); ++k) CHECK(found[k] == Approx(balanced[k]).epsilon(1e-4));
}

TEST_CASE("What stands beside a rotor and does not turn with it keeps its own frequency", "[analyses][quick]") {
  const auto& [axis, stiffness] = GENERATE(table<const char*, double>(
      {{"[1, 0, 0]", 600.0}, {"[0, 1, 0]", 600.0}, {"[0.6, 0.8, 0]", 600.0}, {"[0, 1, 0]", -600.0}}));
  CAPTURE(axis, stiffness);
  const Model model = parse(jeffcott_rotor(55.0, 0.0) + fmt::format(R"toml([[body]]
name = "lever"
mass = 1
inertia = [0.3, 0.3, 0.3]
[[joint]]
name = "pivot"
type = "revolute"
both = {{ z = {}, x = [0, 0, 1] }}
parent = {{ body = "ground", point = [3, 0, 0] }}
child = "lever"
start.turn_z = {{ keep = 0, keep_speed = 0 }}
spring.turn_z = {{ stiffness = {} }}
)toml",
                                                                    axis, stiffness));
  const AnalysisVerdict result = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, result, true));
  CHECK(result.wrenches.outcome == compare::Outcome::agree);
  const double own = std::sqrt(600.0 / 0.3);
  const auto& modes = result.linearizations[1]->modes;
  const bool swings = stiffness > 0.0;
  CHECK(std::any_of(modes.begin(), modes.end(), [own, swings](const auto& mode) {
    const double found = swings ? mode.eigenvalue.imag() : mode.eigenvalue.real();
    return std::abs(found - own) < 1e-6 * own;
  }));
}

TEST_CASE("Modes of a shaft deviate in the axes of the shaft, whatever else turns faster", "[analyses][quick]") {
  const std::string wheel = R"toml([[body]]
name = "wheel"
mass = 0.001
inertia = [1e-6, 1e-6, 1e-6]
[[joint]]
name = "pivot"
type = "revolute"
both = { z = [1, 0, 0], x = [0, 1, 0] }
parent = { body = "ground", point = [3, 0, 0] }
child = "wheel"
start.turn_z = { keep = 0, keep_speed = 100 }
)toml";
  const auto alone = frequencies_in_turning_axes(jeffcott_rotor(55.0, 0.0), "steady in axes that turn");
  const auto found = frequencies_in_turning_axes(jeffcott_rotor(55.0, 0.0) + wheel, "steady in axes that turn");
  REQUIRE(found.size() == alone.size());
  for (std::size_t k = 0; k < found.size(); ++k) CHECK(found[k] == Approx(alone[k]).epsilon(1e-9));
}

TEST_CASE("A pendulum at mid-swing is not steady, though its speed hardly changes there", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "rod"
mass = 1.4
center_of_mass = [0, 0, -0.3]
inertia = [0.02, 0.02, 0.001]
[[joint]]
name = "hinge"
type = "revolute"
both = { z = [0, 1, 0], x = [1, 0, 0] }
parent = "ground"
child = "rod"
start.turn_z = { keep = 0, keep_speed = 7 }
)toml");
  const AnalysisVerdict result = judge_linearization(model, kMakers, false);
  CHECK(result.wrenches.outcome == compare::Outcome::agree);
  CHECK(result.text.find("the motion is not steady") != std::string::npos);
}

/// A frame on an edge, and a fork with an edge of its own that a spring steers straight. Rolling at speed v it has the
/// eigenvalues of J s^2 + (c + J v / L) s + k; along permitted velocities alone the term with v is halved or lost.
std::string steered_skates(double speed) {
  return fmt::format(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "frame"
mass = 5
inertia = [0.2, 0.3, 0.4]
[[body]]
name = "fork"
mass = 0.8
inertia = [0.04, 0.05, 0.06]
[[joint]]
name = "rear"
type = "knife_edge"
parent = "ground"
child = "frame"
start.slide_x = {{ keep = 0, keep_speed = {} }}
start.slide_y = {{ keep = 0 }}
start.turn_z = {{ keep = 0 }}
[[joint]]
name = "steer"
type = "revolute"
parent = {{ body = "frame", point = [1.1, 0, 0] }}
child = "fork"
start.turn_z = {{ keep = 0, keep_speed = 0 }}
spring.turn_z = {{ stiffness = 3, damping = 0.12 }}
[[joint]]
name = "front"
type = "knife_edge"
parent = "ground"
child = "fork"
start.slide_x = {{ guess = 1.1 }}
)toml",
                     speed);
}

TEST_CASE("A note tells that modes leave out how a joint that constrains speeds alone moves on", "[analyses][quick]") {
  const AnalysisVerdict moving = judge_linearization(parse(steered_skates(6.0)), kMakers, false);
  CHECK_THAT(moving.text, Catch::Contains("joint 'rear' (knife_edge) moves and constrains speeds alone"));
  const AnalysisVerdict at_rest = judge_linearization(parse(steered_skates(0.0)), kMakers, false);
  INFO(format_analysis(parse(steered_skates(0.0)), at_rest, true));
  REQUIRE(at_rest.wrenches.outcome == compare::Outcome::agree);
  CHECK(at_rest.text.find("constrains speeds alone") == std::string::npos);
  const auto& modes = at_rest.linearizations[0]->modes;
  const auto steers = [](const auto& mode) { return std::abs(mode.eigenvalue - std::complex(-1.0, 7.0)) < 1e-7; };
  CHECK(std::any_of(modes.begin(), modes.end(), steers));
}

}  // namespace
}  // namespace concord::verification
