#include "compare/audit/machine_size.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

/// The pendulum in a state: its bob is turned about a tilted axis and moves.
State moving(const Model& model, double speed, double turning) {
  State state;
  state.bodies.resize(model.bodies.size());
  state.bodies[1].r = Vec3(0.4, -7.0, 2.0);
  state.bodies[1].v = speed * Vec3(2.0, -1.0, 2.0) / 3.0;
  state.bodies[1].omega = turning * Vec3(-2.0, 2.0, 1.0) / 3.0;
  return state;
}

TEST(MachineSize, OfAMachineBeforeAnyStateIsItsLengthMassAndTheSpeedThatGravityGives) {
  const Model model = pendulum_model();
  const MachineSize size(model);
  EXPECT_DOUBLE_EQ(size.length, model.length_scale());
  EXPECT_DOUBLE_EQ(size.mass, 1.7);
  EXPECT_DOUBLE_EQ(size.place, size.length);
  EXPECT_DOUBLE_EQ(size.falling, std::sqrt(model.gravity.norm() * size.length));
  EXPECT_EQ(size.speed, 0.0);
  EXPECT_DOUBLE_EQ(size.speed_or(0.25), 0.25 * size.natural);
}

TEST(MachineSize, OfMotionIsTheFastestOfAllStatesATurnAtTheLength) {
  const Model model = pendulum_model();
  MachineSize size(model, moving(model, 3.0, 0.0));
  EXPECT_DOUBLE_EQ(size.speed, 3.0);
  EXPECT_DOUBLE_EQ(size.turning, 3.0 / size.length);
  EXPECT_DOUBLE_EQ(size.place, 7.0) << "the largest coordinate";
  size.take(moving(model, 0.0, 50.0));
  EXPECT_DOUBLE_EQ(size.speed, 50.0 * size.length);
  size.take(moving(model, 1.0, 1.0));
  EXPECT_DOUBLE_EQ(size.speed, 50.0 * size.length) << "the largest stays";
  EXPECT_DOUBLE_EQ(size.speed_or(), size.speed);
}

TEST(MachineSize, OfARunThatGravityDoesNotMoveIsTheLengthInItsTime) {
  Model model = pendulum_model();
  model.gravity.setZero();
  Trajectory run;
  for (const double t : {0.0, 0.002}) {
    Sample sample;
    sample.state = moving(model, 0.0, 0.0);
    sample.state.t = t;
    run.samples.push_back(sample);
  }
  const MachineSize size(model, run);
  EXPECT_DOUBLE_EQ(size.natural, size.length / 0.002);
  EXPECT_DOUBLE_EQ(size.speed_or(1e-3), size.length / 2.0);
}

}  // namespace
}  // namespace concord::compare
