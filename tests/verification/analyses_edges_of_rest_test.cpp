#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis_numbers.h"
#include "closed_forms.h"
#include "common/error.h"
#include "common/rotation.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/report.h"
#include "compare/equilibrium/joint_changes.h"
#include "judged_machines.h"

/// Places of rest that end where something begins to push: a stop, or the slope of a road.
namespace concord::verification {
namespace {

using compare::motion_of;
using compare::Outcome;
using compare::analyses::AnalysisVerdict;
using compare::analyses::format_analysis;
using compare::analyses::judge_statics;

AnalysisVerdict rest_of(const std::string& text) {
  const Model model = parse(text);
  AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
  return rest;
}

TEST_CASE("A slide that starts pressed into a stop rests at its edge, where nothing pushes it any more",
          "[analyses][quick]") {
  const AnalysisVerdict rest = rest_of(R"toml(format = 1
[[body]]
name = "bolt"
mass = 0.7
center_of_mass = [0.01, -0.02, 0.03]
inertia = [0.002, 0.003, 0.004]
[[joint]]
name = "guide"
type = "translational"
parent = { body = "ground", point = [0.3, -0.1, 0.2], axis = [1, 2, -1], angle = 0.7 }
child = { body = "bolt", point = [0.02, 0.01, -0.03], axis = [2, -1, 1], angle = 0.4 }
start.slide_z = { keep = 0.01, keep_speed = 0.0 }
spring.slide_z = { upper_stop = { at = 0.004, stiffness = 3e4, width = 0.005 } }
)toml");
  CHECK(value_of(rest, "directions without stiffness") == 1.0);
  CHECK_THAT(value_of(rest, "slide_z of guide"), Catch::WithinAbs(0.004, 1e-5));
}

TEST_CASE("A valve between two stops, pressed into the one, rests at that one's edge and not within its play",
          "[analyses][quick]") {
  const AnalysisVerdict rest = rest_of(R"toml(format = 1
gravity = [0, -9.81, 0]
[[body]]
name = "valve"
mass = 0.2
inertia = [2e-4, 3e-4, 4e-4]
[[joint]]
name = "guide"
type = "translational"
parent = { body = "ground", point = [0.1, 0.2, -0.3], x = [0, 1, 0], z = [3, 0, -4] }
child = { body = "valve", point = [0.01, 0, 0], x = [0, 1, 0], z = [1, 0, 0] }
start.slide_z = { keep = -0.002, keep_speed = 0.0 }
spring.slide_z = { damping = 2.0, lower_stop = { at = -0.0015, stiffness = 2e5, width = 0.0002 }, upper_stop = { at = 0.001, stiffness = 2e5, width = 0.0002 } }
)toml");
  CHECK(value_of(rest, "directions without stiffness") == 1.0);
  CHECK_THAT(value_of(rest, "slide_z of guide"), Catch::WithinAbs(-0.0015, 1e-6));
}

/// A wheel on a column that slides along x, over a road with a bump from `first` on; `spring` pulls the column.
std::string wheel_on_bump(double first, double length, double height, double x, double z, const char* spring) {
  return fmt::format(R"toml(format = 1
gravity = [0, 0, -9.81]
[[road]]
name = "road"
profile = "half_sine"
start = {}
length = {}
height = {}
[[body]]
name = "column"
mass = 2.0
inertia = [0.8, 0.9, 1.1]
[[body]]
name = "wheel"
mass = 15
inertia = [0.7, 0.9, 0.8]
[[joint]]
name = "along"
type = "translational"
parent = {{ body = "ground", x = [0, 1, 0], z = [1, 0, 0] }}
child = {{ body = "column", x = [0, 1, 0], z = [1, 0, 0] }}
start.slide_z = {{ keep = {}, keep_speed = 0.0 }}
{}
[[joint]]
name = "up"
type = "translational"
parent = {{ body = "column", x = [1, 0, 0], z = [0, 0, 1] }}
child = {{ body = "wheel", x = [1, 0, 0], z = [0, 0, 1] }}
start.slide_z = {{ keep = {}, keep_speed = 0.0 }}
[[tire]]
name = "tire"
body = "wheel"
road = "road"
radius = 0.35
stiffness = 8e4
damping = 150.0
slip_stiffness = 2.5e4
cornering_stiffness = 1.5e4
friction = 0.8
)toml",
                     first, length, height, x, spring, z);
}

TEST_CASE("A wheel that rolls off a bump rests where the bump ends, the nearest place on the level road",
          "[analyses][quick]") {
  const AnalysisVerdict rest = rest_of(wheel_on_bump(-0.8, 1.6, 0.03, 0.3, 0.4, ""));
  CHECK_THAT(value_of(rest, "slide_z of along"), Catch::WithinAbs(0.8, 1e-6));
  CHECK_THAT(value_of(rest, "slide_z of up"), Catch::WithinAbs(0.35 - 15 * 9.81 / 8e4, 1e-9));
}

TEST_CASE("Of a wheel that a weak spring presses against the edge of a bump statics says what still moves",
          "[analyses]") {
  const Model model =
      parse(wheel_on_bump(0.0, 0.9, 0.12, -0.4, 0.35, "spring.slide_z = { stiffness = 12.0, free = 1.8 }"));
  CHECK_THROWS_WITH(judge_statics(model, kMakers), Catch::Contains("still accelerates") && Catch::Contains("of along"));
}

/// How far a ball is from the turn about `axis` (of its parent's frame) that brings it nearest to `start` [rad]. Of the
/// turns by s the scalar product of Euler parameters is a cos(s / 2) + b sin(s / 2).
double off_nearest(const Vec4& start, const Vec4& p, const Vec3& axis) {
  Vec4 turned;  // half a turn about the axis, then p
  turned << -axis.dot(p.tail<3>()), p(0) * axis + axis.cross(Vec3(p.tail<3>()));
  return 2.0 * std::atan(start.dot(turned) / start.dot(p));
}

TEST_CASE("Two bodies that hang from balls rest where each ball has turned as little as hanging lets it",
          "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
gravity = [1.2, -3.1, -8.9]
[[body]]
name = "rod"
mass = 3.4
center_of_mass = [-0.106, -0.159, -0.042]
inertia = [0.21, 0.17, 0.29, 0.01, -0.02, 0.03]
[[joint]]
name = "hook"
type = "spherical"
parent = { body = "ground", point = [-0.138, -0.173, -0.039], axis = [0.836, 0.601, 0.53], angle = -0.556 }
child = { body = "rod", point = [0.015, -0.089, -0.131], axis = [-0.788, -0.571, 0.855], angle = 0.658 }
start.ball = { keep = { axis = [0.613, 0.601, -0.613], angle = -1.141 }, keep_speed = [0, 0, 0] }
[[body]]
name = "bob"
mass = 5.2
center_of_mass = [0.051, 0.093, 0.142]
inertia = [0.21, 0.17, 0.29, 0.01, -0.02, 0.03]
[[joint]]
name = "link"
type = "spherical"
parent = { body = "rod", point = [0.152, -0.165, 0.042], axis = [0.343, 0.012, -0.644], angle = -0.053 }
child = { body = "bob", point = [-0.164, 0.174, 0.146], axis = [0.095, -0.4, 0.818], angle = 0.145 }
start.ball = { keep = { axis = [0.765, 0.696, 0.017], angle = -0.516 }, keep_speed = [0, 0, 0] }
)toml");
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
  CHECK_THAT(value_of(rest, "euler_parameter_2 of link"), !Catch::WithinAbs(0.0, 1e-3));
  for (const auto& trajectory : rest.wrenches.trajectories) {
    const State& found = trajectory->samples[0].state;
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      const Attachment& parent = model.joints[k].on(Side::parent);
      const Mat3 frame = rotation_of(found.bodies[parent.body].p) * parent.C;
      const Vec4 p = motion_of(model, k, found).q.head<4>();
      CHECK(std::abs(off_nearest(model.joints[k].start[0].q, p, frame.transpose() * model.gravity.normalized())) <
            1e-9);
    }
  }
}

TEST_CASE("A weight falls on the stop of a line spring, however far above it starts", "[analyses][quick]") {
  const double start = GENERATE(-0.1, 0.0, 0.4, 3.0);  // the spring's other end is 0.3 m below zero
  const Model model = parse(fmt::format(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "weight"
mass = 0.7
inertia = [2e-3, 3e-3, 2.5e-3]
[[joint]]
name = "guide"
type = "translational"
parent = {{ body = "ground", point = [0.4, 0.1, 0] }}
child = "weight"
start.slide_z = {{ keep = {}, keep_speed = 0 }}
[[line_spring]]
name = "buffer"
parent = {{ body = "ground", point = [0.4, 0.1, -0.3] }}
child = "weight"
lower_stop = {{ at = 0.08, stiffness = 3e3, width = 0.001, damping = 4 }}
)toml",
                                        start));
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  REQUIRE(rest.wrenches.outcome == Outcome::agree);
  // Pressed beyond its width it is stiffness times what is beyond half of the width.
  const double expected = -0.3 + 0.08 - (0.7 * 9.81 / 3e3 + 0.0005);
  CHECK(rest.wrenches.trajectories[0]->samples.front().state.q[0](0) == Approx(expected).epsilon(1e-9));
}

TEST_CASE("Where the force of a spring vanishes at rest, the coordinates alone are judged", "[analyses][quick]") {
  const Model model = parse(R"toml(format = 1
[[body]]
name = "puck"
mass = 1.3
inertia = [0.1, 0.2, 0.15]
[[joint]]
name = "space"
type = "free"
parent = "ground"
child = "puck"
start.slide_x = { keep = 0.31, keep_speed = 0 }
start.slide_y = { keep = 0.002, keep_speed = 0 }
start.slide_z = { keep = -0.1, keep_speed = 0 }
start.ball = { keep = { axis = [1, 2, 0], angle = 0.2 }, keep_speed = [0, 0, 0] }
[[line_spring]]
name = "cord"
parent = "ground"
child = "puck"
stiffness = 90
free = 0.12
)toml");
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
  CHECK(rest.wrenches.trajectories[0]->samples.front().state.bodies[1].r.norm() == Approx(0.12));
}

}  // namespace
}  // namespace concord::verification
