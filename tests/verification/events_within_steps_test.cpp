#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>

#include "compare/audit/balance.h"
#include "judged_machines.h"

/// Regimes of tires that begin and end within one step of an integrator.
namespace concord::verification {
namespace {

struct Skid {
  double turn, speed;      // of the start [rad, rad/s]
  double stiffness, free;  // of the hinge's spring
  double slip, cornering, friction, speed_scale;
};

/// A rocker on a tilted hinge whose end drags on the floor: where it turns round, its slip turns round too, and it
/// grips for a moment.
Model dragging_rocker(const Skid& skid) {
  const std::string text = R"(format = 1
name = "dragging_rocker"
gravity = [-2, 1, -9.5]

[[body]]
name = "rocker"
mass = 1.4
center_of_mass = [0.3, -0.1, 0.2]
inertia = [0.31, 0.27, 0.22, 0.01, -0.02, 0.015]

[[road]]
name = "floor"
profile = "flat"
height = 0.02

[run]
until = 0.3
)";
  const std::string joint = R"(
[[joint]]
name = "hinge"
type = "revolute"
parent = {{ body = "ground", point = [0.1, -0.2, 0.35], euler_parameters = [0.8, 0.2, -0.4, 0.4] }}
child = {{ body = "rocker", point = [-0.15, 0.05, 0.1], euler_parameters = [0.7, -0.1, 0.1, 0.7] }}
start.turn_z = {{ keep = {}, keep_speed = {} }}
spring.turn_z = {{ stiffness = {}, free = {} }}
)";
  const std::string tire = R"(
[[tire]]
name = "end"
road = "floor"
body = "rocker"
point = [0.25, 0.2, -0.1]
euler_parameters = [0.9, 0.3, -0.2, 0.25]
radius = 0.6
stiffness = 60
slip_stiffness = {}
cornering_stiffness = {}
friction = {}
speed_scale = {}
)";
  return parse_model(text + fmt::format(fmt::runtime(joint), skid.turn, skid.speed, skid.stiffness, skid.free) +
                         fmt::format(fmt::runtime(tire), skid.slip, skid.cornering, skid.friction, skid.speed_scale),
                     "dragging_rocker.toml");
}

TEST_CASE("A regime that lasts for less than a step is followed, however far apart the samples are", "[events]") {
  const Skid skid =
      GENERATE(Skid{0.09, 0.41, 5, -0.93, 100, 3, 0.2, 0.1}, Skid{-0.31, 2.7, 20, -0.13, 30, 100, 0.4, 0.1},
               Skid{-0.02, -2.02, 60, 0.97, 100, 100, 0.4, 0.1}, Skid{0.34, 1.33, 20, -0.41, 100, 3, 0.2, 0.3});
  const Model model = dragging_rocker(skid);
  for (const auto& make : {cartesian::make_solver, relative::make_solver}) {
    const auto solver = make(model);
    const Trajectory coarse = solver->integrate({model.run.until, 1e-13, 6, ""}, {});
    const Trajectory fine = solver->integrate({model.run.until, 1e-13, 300, ""}, {});
    const BodyState& one = coarse.samples.back().state.bodies[1];
    const BodyState& other = fine.samples.back().state.bodies[1];
    INFO(solver->name() << ", turn " << skid.turn);
    CHECK((one.r - other.r).norm() < 1e-11);
    CHECK((one.omega - other.omega).norm() < 1e-10);
    CHECK(compare::audit_energy(model, coarse).relative() < 1e-12);
  }
}

}  // namespace
}  // namespace concord::verification
