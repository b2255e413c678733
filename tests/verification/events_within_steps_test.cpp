#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "compare/audit/energy.h"
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

/// A fall on a stop that is full after 1 mm, at 3 m/s: a step of free fall reaches so far in that the stop's ramp,
/// continued, overflows. How near the first landing is to an output time decides how long that step is.
TEST_CASE("A mass that falls on a hard stop comes back as high, whatever the output times are", "[events]") {
  const double height = GENERATE(0.05, 0.5, 0.501, 0.6);
  const double stiffness = GENERATE(1e4, 1e5, 1e6);
  const Model model = parse_model(fmt::format(R"(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "ball"
mass = 1
center_of_mass = [0, 0, 0]
inertia = [0.01, 0.01, 0.01]
[[joint]]
name = "guide"
type = "translational"
parent = "ground"
child = "ball"
start.slide_z = {{ keep = {}, keep_speed = 0 }}
spring.slide_z = {{ lower_stop = {{ at = 0, stiffness = {}, width = 0.001 }} }}
)",
                                              height, stiffness),
                                  "fall.toml");
  for (const auto& make : {cartesian::make_solver, relative::make_solver}) {
    const auto solver = make(model);
    const double fall = std::sqrt(2.0 * height / 9.81);
    const Trajectory run = solver->integrate({4.0 * fall, 1e-11, 75, ""}, {});
    INFO(solver->name() << ", from " << height << " m on " << stiffness << " N/m");
    CHECK(compare::audit_energy(model, run).relative() < 1e-9);
    double lowest = 0.0;
    double highest = 0.0;
    for (const Sample& sample : run.samples) {
      lowest = std::min(lowest, sample.state.q[0](0));
      if (sample.state.t > 1.5 * fall) highest = std::max(highest, sample.state.q[0](0));
    }
    CHECK(highest > 0.95 * height);
    CHECK(highest < (1.0 + 1e-9) * height);
    CHECK(lowest > -0.002 - 1.5 * std::sqrt(2.0 * 9.81 * height / stiffness));
  }
}

}  // namespace
}  // namespace concord::verification
