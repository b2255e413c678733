#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "closed_forms.h"
#include "judged_machines.h"

/// Machines that start so near to a singular pose that closing knows their speeds to a few digits only.
namespace concord::verification {
namespace {

/// A parallelogram with arms of `arm` and a bar of `bar`, `angle` [rad] from flat, moving away from it.
Model parallelogram(double arm, double bar, double angle, double speed, double lift) {
  return parse(fmt::format(R"(format = 1
gravity = [0.4, {lift}, 0.3]
[[body]]
name = "left"
mass = 0.9
center_of_mass = [{half_arm}, 0.01, 0.02]
inertia = [0.001, 0.004, 0.0045]
[[body]]
name = "bar"
mass = 1.6
center_of_mass = [{half_bar}, -0.02, 0.01]
inertia = [0.002, 0.05, 0.051]
[[body]]
name = "right"
mass = 0.7
center_of_mass = [{half_arm}, 0.02, -0.01]
inertia = [0.001, 0.003, 0.0035]
[[joint]]
name = "A"
type = "revolute"
parent = "ground"
child = "left"
start.turn_z = {{ keep = {angle}, keep_speed = {speed} }}
[[joint]]
name = "B"
type = "revolute"
parent = {{ body = "left", point = [{arm}, 0, 0] }}
child = "bar"
start.turn_z = {{ guess = {back} }}
[[joint]]
name = "C"
type = "revolute"
parent = {{ body = "bar", point = [{bar}, 0, 0] }}
child = {{ body = "right", point = [{arm}, 0, 0] }}
start.turn_z = {{ guess = {angle} }}
[[joint]]
name = "D"
type = "revolute"
parent = {{ body = "ground", point = [{bar}, 0, 0] }}
child = "right"
start.turn_z = {{ guess = {angle} }}
[run]
until = 0.2
)",
                           fmt::arg("lift", lift), fmt::arg("half_arm", 0.5 * arm), fmt::arg("half_bar", 0.5 * bar),
                           fmt::arg("arm", arm), fmt::arg("bar", bar), fmt::arg("angle", angle),
                           fmt::arg("back", -angle), fmt::arg("speed", speed)));
}

/// A beam that bends and cannot be stretched, straight between two hinges as far apart as it is long.
Model locked_beam() {
  return parse(R"(format = 1
gravity = [0, -7, 0]
[[body]]
name = "strip"
[body.beam]
length = 0.1547
section = { area = 0.0003, second_moment_y = 1.1e-8, second_moment_z = 2.3e-8, torsion_constant = 1.6e-8 }
youngs_modulus = 3.1e7
poissons_ratio = 0.3
density = 9100
support = "free_free"
modes = { bending_xy = [1], bending_xz = [1] }
elements = 6
[[joint]]
name = "left"
type = "revolute"
parent = { body = "strip", node = "6" }
child = { body = "ground", point = [0.09, 0, 0] }
[[joint]]
name = "right"
type = "revolute"
parent = { body = "ground", point = [-0.06, 0, 0] }
child = { body = "strip", node = "0", offset = [0.0047, 0, 0] }
[run]
until = 0.03
)");
}

}  // namespace

TEST_CASE("A parallelogram that starts nearly flat agrees") {
  const Model model = parallelogram(0.27, 0.58, 1.7e-5, 0.8, 7.0);
  const compare::Verdict verdict = judged(model, in_short(model, 1.0));
  INFO(compare::format_verdict(model, verdict, false));
  CHECK(verdict.outcome == compare::Outcome::agree);
}

// Detects starts that are taken as a difference of the motions though neither solver knows its own any better.
TEST_CASE("A parallelogram that starts nearer to flat than closing can tell is refused by name") {
  const Model model = parallelogram(0.27, 0.58, 6e-6, 0.8, 7.0);
  const compare::Verdict verdict = judged(model, in_short(model, 1.0));
  INFO(compare::format_verdict(model, verdict, false));
  CHECK(verdict.outcome == compare::Outcome::failed);
  CHECK(verdict.findings.empty());
  REQUIRE(verdict.failures.size() == 1);
  CHECK_THAT(verdict.failures.front(), Catch::StartsWith("the start is beside a singular pose: "));
  CHECK_THAT(verdict.failures.front(), Catch::EndsWith("of right: start farther from that pose"));
}

// Detects a pose beside a singular one, where a velocity is known to a few digits, that counts as a difference of the
// closures.
TEST_CASE("A beam that is locked between two hinges is in a singular pose, and no difference") {
  const Model model = locked_beam();
  compare::VerifyOptions options;
  options.states = 16;
  options.samples = 15;
  options.refines = false;
  const compare::Verdict verdict = judged(model, options);
  INFO(compare::format_verdict(model, verdict, false));
  CHECK(verdict.outcome == compare::Outcome::failed);
  CHECK(verdict.singular_states > 0);
  CHECK(verdict.findings.empty());
}

}  // namespace concord::verification
