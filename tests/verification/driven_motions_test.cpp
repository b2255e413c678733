#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <initializer_list>
#include <string>

#include "closed_forms.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/kinematics.h"
#include "judged_machines.h"

/// Machines that drivers move fully, closed at few output times: branches and turns do not are attached by these.
namespace concord::verification {
namespace {

const compare::SolverMakers kMakers{cartesian::make_solver, relative::make_solver};

/// A crank of 0.08 m drives a piston in line with its shaft by a rod.
Model driven_slider_crank(const std::string& law, double rod = 0.2) {
  return parse(R"(format = 1
gravity = [1, -9, 2]
[[body]]
name = "crank"
mass = 0.7
center_of_mass = [0.03, 0.01, 0.02]
inertia = [0.001, 0.002, 0.0025]
[[body]]
name = "rod"
mass = 1.3
center_of_mass = [0.09, 0, 0.01]
inertia = [0.001, 0.006, 0.0065]
[[body]]
name = "piston"
mass = 0.9
inertia = [0.001, 0.001, 0.0015]
[[joint]]
name = "shaft"
type = "revolute"
parent = "ground"
child = "crank"
drive.turn_z = )" +
               law + R"(
[[joint]]
name = "pin"
type = "revolute"
parent = { body = "crank", point = [0.08, 0, 0] }
child = "rod"
[[joint]]
name = "gudgeon"
type = "revolute"
parent = { body = "rod", point = [)" +
               fmt::format("{}", rod) + R"(, 0, 0] }
child = "piston"
[[joint]]
name = "bore"
type = "translational"
both = { x = [0, 1, 0], z = [1, 0, 0] }
parent = "ground"
child = "piston"
start.slide_z = { guess = 0.28 }
)");
}

/// Both solvers agree on the motion until then with each number of samples, and the states that they find pass
/// check(state, first state).
template <class Check>
void expect_with_samples(const Model& model, double until, std::initializer_list<int> numbers, Check check) {
  for (const int samples : numbers) {
    INFO(samples);
    compare::VerifyOptions options;
    options.until = until;
    options.samples = samples;
    const auto result = compare::analyses::judge_kinematics(model, kMakers, options);
    REQUIRE(result.wrenches.outcome == compare::Outcome::agree);
    for (const auto& run : result.wrenches.trajectories) {
      for (const Sample& sample : run->samples) check(sample.state, run->samples.front().state);
    }
  }
}

TEST_CASE("A driven slider-crank stays on its branch, however few its output times are", "[analyses][quick]") {
  const Model model = driven_slider_crank(R"({ law = "constant_speed", speed = 11 })");
  expect_with_samples(model, 1.0, {1, 2, 3, 5, 40}, [](const State& state, const State& /*first*/) {
    const double turn = 11.0 * state.t;
    const double place = 0.08 * std::cos(turn) + std::sqrt(0.04 - 0.0064 * std::sin(turn) * std::sin(turn));
    CHECK(state.bodies[3].r.x() == Approx(place).epsilon(1e-12));
    CHECK(state.q[0](0) == Approx(turn).epsilon(1e-12));
  });
}

/// The piston stops for a moment where the rod stands nearly upright: within 0.05 rad of the crank it turns back, and a
/// step that leaps over this finds the branch on which the piston goes on as well closed.
TEST_CASE("A rod hardly longer than its crank does not let the piston pass the shaft", "[analyses]") {
  const double rod = GENERATE(0.0801, 0.0804);
  const Model model = driven_slider_crank(R"({ law = "constant_speed", speed = -47 })", rod);
  expect_with_samples(model, 9.0, {90}, [rod](const State& state, const State& /*first*/) {
    const double turn = 47.0 * state.t;
    const double across = 0.08 * std::sin(turn);
    const double place = 0.08 * std::cos(turn) + std::sqrt(rod * rod - across * across);
    CHECK(state.bodies[3].r.x() == Approx(place).margin(1e-11));
  });
}

TEST_CASE("A drive that leads a linkage through a flat pose is refused, whether or not an output time meets it",
          "[analyses][quick]") {
  const Model model =
      driven_slider_crank(R"({ law = "constant_speed", speed = 2 })", 0.08);  // the rod passes the shaft
  compare::VerifyOptions options;
  options.until = 1.0;
  options.samples = 7;
  CHECK_THROWS_WITH(compare::analyses::judge_kinematics(model, kMakers, options), Catch::Contains("singular pose"));
}

TEST_CASE("Two slides that a rod joins stay on their branch, however far other bodies of the machine are",
          "[analyses][quick]") {
  const double far = GENERATE(0.5, 9.0);
  const Model model = parse(fmt::format(R"(format = 1
[[body]]
name = "across"
mass = 1
inertia = [0.001, 0.001, 0.001]
[[body]]
name = "along"
mass = 0.6
inertia = [0.001, 0.001, 0.001]
[[body]]
name = "fan"
mass = 2
inertia = [0.1, 0.1, 0.1]
[[joint]]
name = "first"
type = "translational"
both = {{ z = [1, 0, 0], x = [0, 1, 0] }}
parent = "ground"
child = "across"
drive.slide_z = {{ law = "harmonic", amplitude = 0.057, frequency = 7 }}
[[joint]]
name = "second"
type = "translational"
both = {{ z = [0, 1, 0], x = [0, 0, 1] }}
parent = "ground"
child = "along"
start.slide_z = {{ guess = 0.06 }}
[[joint]]
name = "rod"
type = "distance"
length = 0.06
parent = "across"
child = "along"
[[joint]]
name = "far"
type = "revolute"
parent = {{ body = "ground", point = [{}, 0, 0] }}
child = {{ body = "fan", point = [0.1, 0, 0] }}
drive.turn_z = {{ law = "constant_speed", speed = 3 }}
)",
                                        far));
  expect_with_samples(model, 1.0, {1, 2, 3, 7, 20}, [](const State& state, const State& /*first*/) {
    const double x = 0.057 * std::sin(7.0 * state.t);
    CHECK(state.bodies[2].r.y() == Approx(std::sqrt(0.0036 - x * x)).epsilon(1e-10));
  });
}

TEST_CASE("A driven wheel and what a gear turns by it count their turns between output times", "[analyses][quick]") {
  const Model model = parse(R"(format = 1
[[body]]
name = "wheel"
mass = 1
center_of_mass = [0.1, 0, 0]
inertia = [0.1, 0.1, 0.12]
[[body]]
name = "pinion"
mass = 0.2
inertia = [0.001, 0.001, 0.0015]
[[joint]]
name = "hinge"
type = "revolute"
parent = "ground"
child = "wheel"
drive.turn_z = { law = "harmonic", amplitude = 23, frequency = 8, phase = 0.3 }
spring.turn_z = { stiffness = 2 }
[[joint]]
name = "bearing"
type = "revolute"
parent = { body = "ground", point = [0.5, 0, 0] }
child = "pinion"
[[coupling]]
name = "gear"
terms = [{ joint = "hinge", coordinate = "turn_z", factor = 1 }, { joint = "bearing", coordinate = "turn_z", factor = 0.4 }]
)");
  expect_with_samples(model, 1.3, {1, 3, 7}, [](const State& state, const State& first) {
    const double turned = 23.0 * (std::sin(8.0 * state.t + 0.3) - std::sin(0.3));
    CHECK(state.q[0](0) - first.q[0](0) == Approx(turned).margin(1e-10));
    CHECK(state.q[1](0) - first.q[1](0) == Approx(-2.5 * turned).margin(1e-10));
  });
}

TEST_CASE("A skate is no machine for kinematics, though its speeds are driven", "[analyses][quick]") {
  const Model model = parse(R"(format = 1
[[body]]
name = "skate"
mass = 2
center_of_mass = [0.1, 0.05, 0.2]
inertia = [0.1, 0.2, 0.15]
[[joint]]
name = "edge"
type = "knife_edge"
parent = "ground"
child = "skate"
drive.slide_x = { law = "harmonic", amplitude = 0.5, frequency = 2 }
start.slide_y = { keep = 0.2 }
drive.turn_z = { law = "harmonic", amplitude = 0.8, frequency = 3 }
)");
  for (const auto& make : {cartesian::make_solver, relative::make_solver}) {
    CHECK_THROWS_WITH(compare::analyses::run_kinematics(model, *make(model), {}),
                      Catch::Contains("joint 'edge' (knife_edge) constrains speeds"));
  }
}

}  // namespace
}  // namespace concord::verification
