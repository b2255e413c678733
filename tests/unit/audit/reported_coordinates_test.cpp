#include "compare/audit/reported_coordinates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "cartesian/solver.h"
#include "common/reading/model_file.h"
#include "relative/solver.h"

namespace concord::compare {
namespace {

using testing::HasSubstr;

/// A slide and a turn on a body that hangs by a ball, in tilted frames.
Model machine() {
  return parse_model(R"(format = 1
gravity = [0.4, -0.3, -9.7]
[[body]]
name = "arm"
mass = 2
center_of_mass = [0.1, 0.02, -0.3]
inertia = [0.3, 0.25, 0.1]
[[body]]
name = "sleeve"
mass = 0.7
center_of_mass = [0.02, -0.01, 0.03]
inertia = [0.004, 0.005, 0.003]
[[joint]]
name = "shoulder"
type = "spherical"
parent = { body = "ground", axis = [1, 2, -0.5], angle = "40 deg" }
child = { body = "arm", point = [0.01, 0, 0.1], axis = [0.2, 1, 0.5], angle = "25 deg" }
start.ball = { keep = { axis = [1, 0.3, 0], angle = "30 deg" }, keep_speed = [0.5, -1.2, 2] }
[[joint]]
name = "guide"
type = "cylindrical"
parent = { body = "arm", point = [0, 0.05, -0.2], axis = [0.3, 0.2, 1], angle = "70 deg" }
child = "sleeve"
start.slide_z = { keep = 0.1, keep_speed = 0.4 }
start.turn_z = { keep = "200 deg", keep_speed = -3 }
)",
                     "reported.toml");
}

using Spoil = std::function<void(State&)>;

class Reported : public ::testing::TestWithParam<bool> {
 protected:
  static ReportedCoordinate audit(const Spoil& spoil) {
    const Model model = machine();
    const auto solver = GetParam() ? cartesian::make_solver(model) : relative::make_solver(model);
    Trajectory run = solver->integrate({0.3, 1e-11, 20, ""}, {});
    for (Sample& sample : run.samples) {
      if (sample.state.t > 0.1) spoil(sample.state);
    }
    return audit_reported_coordinates(model, run);
  }
};

}  // namespace

TEST_P(Reported, CoordinatesOfARunAreThoseOfItsBodies) {
  const ReportedCoordinate found = audit([](State&) {});
  EXPECT_TRUE(found.holds()) << found.text();
  EXPECT_GT(found.digits, 12.0) << found.text();
}

TEST_P(Reported, WrongOnesAreNamed) {
  const auto text = [](const Spoil& spoil) {
    const ReportedCoordinate found = audit(spoil);
    EXPECT_FALSE(found.holds());
    return found.text();
  };
  EXPECT_THAT(text([](State& state) { state.q[1](0) *= 1.001; }), HasSubstr("joint 'guide', slide_z, t = "));
  EXPECT_THAT(text([](State& state) { state.q[1](1) += 1e-6; }), HasSubstr("joint 'guide', turn_z, t = "));
  EXPECT_THAT(text([](State& state) { state.u[1] = -state.u[1]; }), HasSubstr("joint 'guide', speed of turn_z, t = "));
  EXPECT_THAT(text([](State& state) { state.u[0].reverseInPlace(); }), HasSubstr("joint 'shoulder', speed of ball"));
  EXPECT_THAT(text([](State& state) { state.q[0].tail<3>() *= -1.0; }), HasSubstr("joint 'shoulder', ball, t = "));
}

TEST_P(Reported, SignOfEulerParametersAndWholeTurnsAreFree) {
  EXPECT_TRUE(audit([](State& state) { state.q[0] = -state.q[0]; }).holds());
  EXPECT_TRUE(audit([](State& state) { state.q[1](1) += 4.0 * EIGEN_PI; }).holds());
}

INSTANTIATE_TEST_SUITE_P(OfEachSolver, Reported, ::testing::Bool());

}  // namespace concord::compare
