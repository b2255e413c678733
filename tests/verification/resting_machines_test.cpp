#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>

#include "closed_forms.h"
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

}  // namespace

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

}  // namespace concord::verification
