#include "compare/invariance/invariance_checks.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>

#include "cartesian/solver.h"
#include "common/reading/model_file.h"
#include "compare/equilibrium/started_machine.h"
#include "compare/invariance/report.h"
#include "judged_machines.h"
#include "relative/solver.h"

/// The checks of `concord invariance` on shipped machines: whatever words a file chooses, each solver says the same of
/// what is physical. Detects a mistake in one solver that depends on the words: a side, a frame, an order, a unit.
namespace concord::verification {
namespace {

std::filesystem::path shipped_models() { return std::filesystem::path(CONCORD_DATA) / "models"; }

Model shipped(const std::string& name) { return read_model(shipped_models() / (name + ".toml")); }

/// Set CONCORD_PRINT_DIGITS to see the tables.
void expect_invariance(const Model& stated) {
  const compare::SolverMakers makers{cartesian::make_solver, relative::make_solver};
  std::string note;
  const Model model = compare::as_it_starts(stated, makers, note);
  const compare::invariance::InvarianceChecks checks = compare::invariance::check_invariance(model, makers, {});
  const std::string table = compare::invariance::format_checks(model, checks);
  if (std::getenv("CONCORD_PRINT_DIGITS") != nullptr) std::cout << table << std::flush;
  INFO(table);
  CHECK(checks.outcome == compare::Outcome::agree);
  CHECK(checks.run_states > 5);
  CHECK(checks.random_states > 0);
}

TEST_CASE("Each solver says the same of a machine, however it is described", "[invariance]") {
  const std::string name = GENERATE("slider_crank_spatial_flexible", "slider_crank_redundant", "planetary_differential",
                                    "suspension_two_rods", "tire_test_rig", "chaplygin_sleigh", "driven_linkage",
                                    "joint_springs_tree", "loads_on_rigid_bodies");
  DYNAMIC_SECTION(name) { expect_invariance(shipped(name)); }
}

// Screws, tables, stops, turns beyond half a circle, modes files: what no shipped model has.
TEST_CASE("Each solver says the same of rare machines, however they are described", "[invariance]") {
  for (const std::string& name : machines_of("rare")) {
    DYNAMIC_SECTION(name) { expect_invariance(machine_of("rare", name)); }
  }
}

// Detects a resolution that forgets what springs cancel: all that this machine passes is round-off.
TEST_CASE("Each solver says the same of a machine at rest, however it is described", "[invariance]") {
  expect_invariance(machine_of("resting", "train"));
}

// Detects a floor that knows only what joints pass on: of a balanced rotor in space that is nothing, to round-off.
TEST_CASE("Each solver says the same of a balanced rotor in space, however it is described", "[invariance]") {
  expect_invariance(parse_model(R"(format = 1
[[body]]
name = "rotor"
mass = 1.3
inertia = [0.011, 0.012, 0.014]
[[joint]]
name = "bearing"
type = "revolute"
parent = "ground"
child = "rotor"
drive.turn_z = { law = "harmonic", amplitude = 0.5, frequency = 11 }
[run]
until = 0.2
)",
                                "rotor.toml"));
}

// Detects a start that is asked for more digits than closing has near a singular pose.
TEST_CASE("Each solver says the same of a loop near a singular pose, however it is described", "[invariance]") {
  expect_invariance(machine_of("modes", "nearly_flat"));
}

// Detects a closing that is asked for more digits than a law of many turns has: another frame shifts the law.
TEST_CASE("Each solver says the same of a motor that has turned for a minute, however it is described",
          "[invariance]") {
  expect_invariance(parse_model(R"(format = 1
gravity = [1.3, -8.7, 2.2]
[[body]]
name = "rotor"
mass = 1.9
center_of_mass = [0.09, 0.03, 0.04]
inertia = [0.021, 0.032, 0.029, 0.001, -0.002, 0.001]
[[joint]]
name = "bearing"
type = "revolute"
parent = { body = "ground", point = [0.1, -0.2, 0.3], axis = [1, 2, -1], angle = 0.7 }
child = { body = "rotor", axis = [1, -1, 3], angle = 1.3 }
drive.turn_z = { law = "constant_speed", speed = 520 }
[run]
until = 60
samples = 50
)",
                                "motor.toml"));
}

// Detects a mirrored arm whose turns are about other lines, which two arms in one plane do not permit.
TEST_CASE("Each solver says the same of a load on two rods in one plane, however it is described", "[invariance]") {
  expect_invariance(parse_model(R"(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "load"
mass = 2.3
inertia = [0.4, 1.4, 1.2]
start.pose = { origin = [0.1, 0.05, 1.7], rotation_vector = [0, 0, 0] }
[[joint]]
name = "left"
type = "distance"
parent = { body = "ground", point = [-2, 0, 4], x = [0, 1, 0], z = [0.6, 0, -0.8] }
child = { body = "load", point = [-0.6, -0.05, 0.3], x = [0, 1, 0], z = [0.6, 0, -0.8] }
length = 2.5
start.ball = { keep = { axis = [0, 0, 1], angle = 0 }, keep_speed = [0.02, 0.01, 0] }
start.turn_y = { keep = 0, keep_speed = 0.02 }
[[joint]]
name = "right"
type = "distance"
parent = { body = "ground", point = [2, 0, 4], x = [0, 1, 0], z = [-0.6, 0, -0.8] }
child = { body = "load", point = [0.4, -0.05, 0.3], x = [0, 1, 0], z = [-0.6, 0, -0.8] }
length = 2.5
[run]
until = 0.5
)",
                                "load.toml"));
}

TEST_CASE("Each solver says the same of textbook machines, however they are described", "[invariance][nightly]") {
  for (const std::string& name : machines_of("textbook")) {
    DYNAMIC_SECTION(name) { expect_invariance(machine_of("textbook", name)); }
  }
}

TEST_CASE("Each solver says the same of every shipped machine, however it is described", "[invariance][nightly]") {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(shipped_models())) {
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  REQUIRE(names.size() >= 40);
  for (const std::string& name : names) {
    DYNAMIC_SECTION(name) { expect_invariance(shipped(name)); }
  }
}

}  // namespace
}  // namespace concord::verification
