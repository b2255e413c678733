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

/// Between two points of a road table the third derivative is constant, at a point it jumps, and with it the change of
/// a damped tire's force. A quarter of a car, hurried over a road by a driver.
TEST_CASE("A damped tire moves alike in both solvers over the points of a road table", "[events][quick]") {
  const double spacing = GENERATE(0.09, 0.31);
  std::string x;
  std::string height;
  for (int k = 0; k * spacing < 9.0; ++k) {
    x += fmt::format("{}{:.4f}", k == 0 ? "" : ", ", k * spacing);
    height += fmt::format("{}{:.5f}", k == 0 ? "" : ", ", 0.006 * std::sin(2.1 * k) + 0.003 * std::sin(0.7 * k));
  }
  const Model model = parse_model(fmt::format(R"(format = 1
gravity = [0, 0, -9.81]
[[road]]
name = "worn"
profile = "table"
x = [{}]
height = [{}]
[[body]]
name = "dolly"
mass = 12
inertia = [1, 1.2, 0.9]
[[body]]
name = "axle"
mass = 65
inertia = [1.4, 1.1, 1.3]
[[joint]]
name = "pull"
type = "translational"
parent = {{ body = "ground", z = [1, 0, 0], x = [0, 1, 0] }}
child = {{ body = "dolly", z = [1, 0, 0], x = [0, 1, 0] }}
drive.slide_z = {{ law = "constant_speed", speed = 9.3 }}
[[joint]]
name = "strut"
type = "translational"
parent = "dolly"
child = "axle"
start.slide_z = {{ keep = 0.27, keep_speed = 0 }}
[[tire]]
name = "tire"
body = "axle"
road = "worn"
radius = 0.28
stiffness = 7e4
damping = 350
slip_stiffness = 0
cornering_stiffness = 0
friction = 0
[run]
until = 0.6
)",
                                              x, height),
                                  "worn_road.toml");
  const RunOptions options{0.6, 1e-12, 60, ""};
  const Trajectory one = cartesian::make_solver(model)->integrate(options, {});
  const Trajectory other = relative::make_solver(model)->integrate(options, {});
  for (std::size_t k = 0; k < one.samples.size(); ++k) {
    INFO("t = " << one.samples[k].state.t << " s, a point each " << spacing << " m");
    CHECK((one.samples[k].state.bodies[2].v - other.samples[k].state.bodies[2].v).norm() < 1e-9);
  }
}

/// The tire begins to push, slides, grips for a microsecond and slides the other way, all within a step of 0.7 ms
/// behind an event: its sliding event function is not quite convex there.
TEST_CASE("A tire that turns its slip round just as it begins to push moves alike, however far samples are apart",
          "[quick]") {
  const Model model = parse_model(R"toml(format = 1
name = "nut_on_the_floor"
gravity = [4.439, 8.545, -1.875]

[[body]]
name = "nut"
mass = 2.023
center_of_mass = [0.03792, -0.03743, 0.01013]
inertia = [0.003815, 0.004475, 0.004239, 7.01e-05, -0.0001829, 0.00047]

[[joint]]
name = "thread"
type = "screw"
lead = 0.01517
parent = { body = "ground", point = [0.02394, 0.05346, 0.08424], euler_parameters = [0.7656, -0.0803, -0.5974, -0.2248] }
child = { body = "nut", point = [-0.07926, 0.02475, 0.0819], euler_parameters = [0.5378, -0.5804, 0.03884, -0.6103] }
start.turn = { keep = 0.1992, keep_speed = -2.573 }

[[bushing]]
name = "mount"
parent = { body = "nut", point = [-0.006383, 0.05687, -0.03512], euler_parameters = [0.5517, 0.2558, -0.1176, -0.7851] }
child = { body = "ground", point = [-0.02731, -0.06429, 0.007169], euler_parameters = [0.8295, 0.535, -0.1444, 0.06943] }
stiffness = [[1126, -314.4, -71.99, 21.65, -17.2, 9.246], [-314.4, 668.5, 134, 9.762, -4.854, -19.92], [-71.99, 134, 1347, 5.383, -24.01, -17.49], [21.65, 9.762, 5.383, 24.02, -2.601, -1.483], [-17.2, -4.854, -24.01, -2.601, 12.17, 0.3984], [9.246, -19.92, -17.49, -1.483, 0.3984, 20.26]]
damping = [[16.67, -0.03095, 0.3605, 0.3859, 0.3477, 0.1046], [-0.03095, 24.22, -1.841, -0.6394, 0.1215, -0.1153], [0.3605, -1.841, 11.72, -0.07619, -0.2021, -0.1218], [0.3859, -0.6394, -0.07619, 0.5786, 0.09558, 0.06534], [0.3477, 0.1215, -0.2021, 0.09558, 0.4015, 0.08598], [0.1046, -0.1153, -0.1218, 0.06534, 0.08598, 0.4672]]
preload = [-14.93, 2.206, -11, 1.403, 0.4878, 2.267]

[[road]]
name = "floor"
profile = "flat"
height = -0.06602

[[tire]]
name = "tire"
road = "floor"
body = "nut"
point = [-0.01721, 0.002621, -0.06187]
euler_parameters = [0.2809, -0.6752, 0.1845, 0.6567]
radius = 0.07961
stiffness = 1806
slip_stiffness = 174.9
cornering_stiffness = 133.7
friction = 0.9547
speed_scale = 0.3691
damping = 13

[run]
until = 0.034
)toml",
                                  "nut_on_the_floor.toml");
  for (const auto& make : {cartesian::make_solver, relative::make_solver}) {
    const Trajectory often = make(model)->integrate({0.034, 1e-11, 300, ""}, {});
    const Trajectory seldom = make(model)->integrate({0.034, 1e-11, 15, ""}, {});
    for (std::size_t k = 0; k < seldom.samples.size(); ++k) {
      const BodyState& one = seldom.samples[k].state.bodies[1];
      const BodyState& other = often.samples[20 * k].state.bodies[1];
      INFO("t = " << seldom.samples[k].state.t);
      CHECK((one.v - other.v).norm() < 1e-9);
      CHECK((one.omega - other.omega).norm() < 1e-8);
    }
  }
}

// Sliding whose slip passes zero within a step of the extrapolated midpoint rule: all midpoints on one side, all
// results on the other, and all of them alike.
TEST_CASE("A braked wheel that hops over the road keeps its energy in both solvers", "[events]") {
  const double speed = GENERATE(1.0, 1.5, 2.2);
  const Model model = parse_model(fmt::format(R"toml(format = 1
name = "braked_wheel"
gravity = [0, 0, -9.81]

[[body]]
name = "sled"
mass = 100
inertia = [1, 1, 1]

[[body]]
name = "fork"
mass = 10
inertia = [0.1, 0.1, 0.1]

[[body]]
name = "wheel"
mass = 20
inertia = [0.5, 0.9, 0.5]

[[joint]]
name = "way"
type = "translational"
both = {{ x = [0, 1, 0], z = [1, 0, 0] }}
parent = "ground"
child = "sled"
start.slide_z = {{ keep = 0, keep_speed = {0:.17g} }}

[[joint]]
name = "strut"
type = "translational"
parent = "sled"
child = "fork"
start.slide_z = {{ keep = 0.29, keep_speed = 0 }}
spring.slide_z = {{ stiffness = 2e4, preload = -1000, free = 0.29 }}

[[joint]]
name = "hub"
type = "revolute"
both = {{ x = [1, 0, 0], z = [0, 1, 0] }}
parent = "fork"
child = "wheel"
start.turn_z = {{ keep = 0, keep_speed = {1:.17g} }}
spring.turn_z = {{ damping = 60 }}

[[road]]
name = "floor"
profile = "flat"

[[tire]]
name = "tire"
body = "wheel"
road = "floor"
radius = 0.3
stiffness = 2e5
damping = 0
slip_stiffness = 4e4
cornering_stiffness = 3e4
friction = 0.8

[run]
until = 3
)toml",
                                              speed, speed / 0.3),
                                  "braked_wheel.toml");
  for (const auto& make : {cartesian::make_solver, relative::make_solver}) {
    const auto solver = make(model);
    const Trajectory run = solver->integrate({model.run.until, 1e-11, 200, ""}, {});
    INFO(solver->name() << ", from " << speed << " m/s");
    CHECK(compare::audit_energy(model, run).relative() < 1e-11);
  }
}

}  // namespace
}  // namespace concord::verification
