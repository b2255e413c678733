#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "compare/audit/energy.h"
#include "judged_machines.h"

/// Bodies far lighter than those that they link, as dummies in a model are.
namespace concord::verification {
namespace {

/// A crank-rocker whose rocker has the given part of 1.5 kg.
Model crank_rocker(double part) {
  return parse_model(fmt::format(R"toml(format = 1
gravity = [0, -9.81, 0]
[[body]]
name = "crank"
mass = 1
center_of_mass = [0.1, 0, 0]
inertia = [0.001, 0.0033, 0.0033]
[[body]]
name = "coupler"
mass = 2
center_of_mass = [0.25, 0.01, 0]
inertia = [0.002, 0.042, 0.043]
[[body]]
name = "rocker"
mass = {}
center_of_mass = [0.2, 0, 0.01]
inertia = [{}, {}, {}]
[[joint]]
name = "A"
type = "revolute"
parent = "ground"
child = "crank"
start.turn_z = {{ keep = "30 deg", keep_speed = 2 }}
[[joint]]
name = "B"
type = "spherical"
parent = {{ body = "crank", point = [0.2, 0, 0] }}
child = "coupler"
[[joint]]
name = "C"
type = "universal"
parent = {{ body = "coupler", point = [0.5, 0, 0], x = [0, 0, 1], y = [1, 0, 0] }}
child = {{ body = "rocker", x = [0, 0, 1], y = [1, 0, 0], point = [0.4, 0, 0] }}
[[joint]]
name = "D"
type = "revolute"
parent = {{ body = "ground", point = [0.45, 0, 0] }}
child = "rocker"
start.turn_z = {{ guess = "80 deg" }}
)toml",
                                 1.5 * part, 0.0015 * part, 0.02 * part, 0.021 * part),
                     "crank_rocker.toml");
}

TEST_CASE("A link a hundred million times lighter than its neighbours costs no steps", "[light]") {
  for (const auto& make : {cartesian::make_solver, relative::make_solver}) {
    const Model heavy = crank_rocker(1.0);
    const long steps = make(heavy)->integrate({1.0, 1e-11, 300, ""}, {}).statistics.steps;
    for (const double part : {1e-3, 1e-6, 1e-8}) {
      const Model light = crank_rocker(part);
      const auto solver = make(light);
      const Trajectory run = solver->integrate({1.0, 1e-11, 300, ""}, {});
      INFO(solver->name() << ", " << part);
      CHECK(run.statistics.steps < 2 * steps);
      CHECK(compare::audit_energy(light, run).relative() < 1e-10);
    }
  }
}

}  // namespace
}  // namespace concord::verification
