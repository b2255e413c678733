#include "relative/run/integration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "machines.h"
#include "relative/solver.h"

namespace concord::relative {
namespace {

RunOptions options(double until, int samples, double rtol, const std::string& integrator = "") {
  RunOptions chosen;
  chosen.until = until;
  chosen.samples = samples;
  chosen.rtol = rtol;
  chosen.integrator = integrator;
  return chosen;
}

/// A symmetric body in free flight: omega turns about the symmetry axis at (I_3 - I_1) / I_1 omega_3 in body axes.
Model free_symmetric_body() {
  Model model;
  model.file = "free.toml";
  test::Numbers numbers(14);
  model.bodies = {test::ground(), test::rigid_body("puck", numbers)};
  model.bodies[1].center_of_mass_L.setZero();
  model.bodies[1].inertia_L = Vec3(0.02, 0.02, 0.034).asDiagonal();
  model.joints = {test::joint(model, "flight", "free", 0, 1, numbers)};
  model.joints[0].sides[1].point_L.setZero();
  model.joints[0].sides[1].C.setIdentity();
  return model;
}

double error_of_free_flight(const Trajectory& trajectory) {
  const BodyState& first = trajectory.samples.front().state.bodies[1];
  const BodyState& last = trajectory.samples.back().state.bodies[1];
  const Vec3 w0 = test::rotation_of(first).transpose() * first.omega;
  const double turn = (0.034 - 0.02) / 0.02 * w0.z() * trajectory.samples.back().state.t;
  const Vec3 expected = rotation_about(Axis::z, turn) * w0;
  const Vec3 momentum = test::rotation_of(first) * Vec3(Vec3(0.02, 0.02, 0.034).asDiagonal() * w0);
  const Vec3 omega = test::rotation_of(last).transpose() * last.omega;
  const Vec3 reached = test::rotation_of(last) * Vec3(Vec3(0.02, 0.02, 0.034).asDiagonal() * omega);
  return (omega - expected).norm() + (momentum - reached).norm() / 0.02;
}

TEST(Integration, FollowsTheClosedFormOfAFreeSymmetricBody) {
  const Model model = free_symmetric_body();
  for (const std::string integrator : {"adams", "dirk"}) {
    const Trajectory run = make_solver(model)->integrate(options(4.0, 8, 1e-10, integrator), {});
    EXPECT_LT(error_of_free_flight(run), 1e-7) << integrator;
  }
}

TEST(Integration, EndsAfterTheStepInWhichNobodyWantsItAnyMore) {
  const Model model = free_symmetric_body();
  for (const std::string integrator : {"adams", "dirk"}) {
    double reached = 0.0;
    const auto stop = [&](double t) {
      reached = t;
      throw std::string("enough");
    };
    EXPECT_THROW((void)make_solver(model)->integrate(options(4.0, 1, 1e-10, integrator), stop), std::string);
    EXPECT_GT(reached, 0.0) << integrator;
    EXPECT_LT(reached, 0.1) << integrator;
  }
}

/// A mass on a slide.
Model mass_on_slide(unsigned seed) {
  test::Numbers numbers(seed);
  Model model;
  model.file = "slide.toml";
  model.bodies = {test::ground(), test::rigid_body("mass", numbers)};
  model.joints = {test::joint(model, "slide", "translational", 0, 1, numbers)};
  return model;
}

/// A slide with a spring and a damper: x = exp(-d t) (x0 cos w t + (v0 + d x0) / w sin w t), about its place of rest.
TEST(Integration, FollowsTheClosedFormOfADampedMass) {
  Model model = mass_on_slide(33);
  const double mass = model.bodies[1].mass;
  const double d = 0.8;
  const double w = 7.0;
  const double free = 0.15;
  JointSpring spring;
  spring.law.free = free;
  spring.law.damping = 2.0 * d * mass;
  spring.law.stiffness = mass * (w * w + d * d);
  model.joints[0].springs = {spring};
  const double x0 = model.joints[0].start[0].q(0) - free;
  const double v0 = model.joints[0].start[0].u(0);
  for (const std::string integrator : {"adams", "dirk"}) {
    const Trajectory run = make_solver(model)->integrate(options(1.5, 6, 1e-10, integrator), {});
    for (const Sample& sample : run.samples) {
      const double t = sample.state.t;
      const double x = std::exp(-d * t) * (x0 * std::cos(w * t) + (v0 + d * x0) / w * std::sin(w * t));
      EXPECT_NEAR(sample.state.q[0](0), free + x, 1e-8) << integrator << " " << t;
      const double kinetic = 0.5 * mass * sample.state.u[0](0) * sample.state.u[0](0);
      EXPECT_NEAR(sample.work, kinetic - 0.5 * mass * v0 * v0, 1e-7) << integrator << " " << t;
    }
  }
}

/// A method whose error estimate is zero where rates depend on time alone loses the work of drivers that move all
/// bodies: here of a rod that turns 480 times under gravity, with 50 outputs.
TEST(Integration, WorkOfDriversThatMoveEverythingIsHeldToTheTolerance) {
  test::Numbers numbers(34);
  Model model;
  model.file = "rod.toml";
  model.gravity = Vec3(0.3, -9.81, 0.2);
  model.bodies = {test::ground(), test::rigid_body("rod", numbers)};
  model.joints = {test::joint(model, "hinge", "revolute", 0, 1, numbers)};
  test::release(model.joints[0]);
  model.joints[0].drivers.push_back({0, ConstantSpeed{0.2, 300.0}});
  const Trajectory run = make_solver(model)->integrate(options(10.0, 50, 1e-11, "adams"), {});
  const double start = test::energy(model, run.samples.front().state);
  double largest = 0.0;
  for (const Sample& sample : run.samples) {
    const double gained = test::energy(model, sample.state) - start;
    largest = std::max(largest, std::abs(gained));
    EXPECT_NEAR(sample.work, gained, 1e-9) << sample.state.t;
  }
  EXPECT_GT(largest, 0.1);
}

TEST(Integration, AdamsGainsSevenDigitsPerDecadeOfStepsAtLeast) {
  Model model = test::spatial_slider_crank(false);
  const auto pose_at_end = [&](double rtol, long& steps) {
    const Trajectory run = make_solver(model)->integrate(options(2.0, 1, rtol, "adams"), {});
    steps = run.statistics.steps;
    return VecX(run.samples.back().state.bodies[2].r);
  };
  long steps = 0;
  const VecX exact = pose_at_end(1e-13, steps);
  long coarse_steps = 0;
  long fine_steps = 0;
  const double coarse = (pose_at_end(1e-4, coarse_steps) - exact).norm();
  const double fine = (pose_at_end(1e-8, fine_steps) - exact).norm();
  const double order = std::log(coarse / fine) / std::log(static_cast<double>(fine_steps) / coarse_steps);
  RecordProperty("order", std::to_string(order));
  EXPECT_GT(order, 6.5);
}

TEST(Integration, ExplicitAndImplicitAgreeOnAFlexibleLoop) {
  const Model model = test::spatial_slider_crank(true);
  const Trajectory one = make_solver(model)->integrate(options(0.5, 5, 1e-10, "adams"), {});
  const Trajectory other = make_solver(model)->integrate(options(0.5, 5, 1e-10, "dirk"), {});
  for (std::size_t i = 0; i < one.samples.size(); ++i) {
    EXPECT_LT((one.samples[i].state.bodies[3].r - other.samples[i].state.bodies[3].r).norm(), 1e-7);
    EXPECT_LT((one.samples[i].state.bodies[2].a - other.samples[i].state.bodies[2].a).norm(), 1e-7);
  }
}

TEST(Integration, ConservesEnergyUpToTheWorkDone) {
  for (const int cut : {0, 1}) {
    Model model = test::spatial_slider_crank(true);
    model.joints[cut].named_as_cut = true;
    test::release(model.joints[0]);
    model.joints[0].drivers.push_back({0, Harmonic{model.joints[0].start[0].q(0), 0.3, 6.0, 0.0}});
    const Trajectory run = make_solver(model)->integrate(options(0.6, 6, 1e-10), {});
    const double before = test::energy(model, run.samples.front().state);
    double work = 0.0;
    for (const Sample& sample : run.samples) {
      EXPECT_NEAR(test::energy(model, sample.state) - sample.work, before, 1e-8);
      work = std::max(work, std::abs(sample.work));
    }
    EXPECT_GT(work, 0.1);
  }
}

TEST(Integration, CountsTurnsOfTreeAndCutJoints) {
  for (const int cut : {0, 1, 2, 3}) {
    Model model = test::four_bar();
    model.joints[cut].named_as_cut = true;
    test::release(model.joints[0]);
    const double q = model.joints[0].start[0].q(0);
    model.joints[0].drivers.push_back({0, ConstantSpeed{q, 31.0}});
    const Trajectory run = make_solver(model)->integrate(options(1.0, 40, 1e-9), {});
    EXPECT_NEAR(run.samples.back().state.q[0](0), q + 31.0, 1e-12);
    // The coupler's hinges turn with the crank and never jump.
    for (std::size_t i = 1; i < run.samples.size(); ++i) {
      EXPECT_LT(std::abs(run.samples[i].state.q[1](0) - run.samples[i - 1].state.q[1](0)), 2.0);
    }
    EXPECT_LT(run.statistics.max_constraint, 1e-13);
  }
}

TEST(Integration, StopsAtTheGridAndReportsWhatItDid) {
  const Model model = test::spatial_slider_crank(false);
  std::vector<double> reported;
  const Trajectory run = make_solver(model)->integrate(options(0.7, 7, 1e-8), [&](double t) { reported.push_back(t); });
  ASSERT_EQ(run.samples.size(), 8u);
  for (int i = 0; i <= 7; ++i) EXPECT_EQ(run.samples[i].state.t, 0.7 * i / 7);
  EXPECT_EQ(reported.back(), 0.7);
  EXPECT_GT(run.statistics.steps, 7);
  EXPECT_GE(run.statistics.evaluations, 2 * run.statistics.steps);
  EXPECT_GT(run.statistics.wall_s, 0.0);
  EXPECT_LT(run.statistics.max_constraint, 1e-14);
  EXPECT_GT(run.statistics.max_constraint, 0.0);
}

TEST(Integration, SaysWhenAndWhichLoopLocks) {
  // The slide is driven out of reach.
  Model model = test::spatial_slider_crank(false);
  test::release(model.joints[0]);
  model.joints[3].drivers.push_back({0, ConstantSpeed{model.joints[3].start[0].q(0), -0.6}});
  try {
    (void)make_solver(model)->integrate(options(2.0, 4, 1e-8), {});
    FAIL() << "a locked loop was driven on";
  } catch (const SolverError& error) {
    const std::string text = error.what();
    EXPECT_TRUE(text.starts_with("relative: at t = 1.2")) << text;
    EXPECT_NE(text.find("the loop of joint 'B'"), std::string::npos) << text;
  }
}

TEST(Integration, RefusesStepsThatGetNowhere) {
  Model model = mass_on_slide(34);
  JointSpring spring;
  spring.law.free = model.joints[0].start[0].q(0) - 0.1;
  spring.law.stiffness = 1e24;
  model.joints[0].springs = {spring};
  try {
    (void)make_solver(model)->integrate(options(1.0, 4, 1e-8), {});
    FAIL() << "a spring of 1e24 N/m was followed by an explicit integrator";
  } catch (const SolverError& error) {
    const std::string text = error.what();
    EXPECT_TRUE(text.starts_with("relative: at t = ")) << text;
    EXPECT_NE(text.find(" s 300000 evaluations advanced the run by "), std::string::npos) << text;
    EXPECT_NE(text.find("the motion locks there, or is too stiff for adams"), std::string::npos) << text;
  }
}

TEST(Integration, NamesTheIntegratorsItHas) {
  const Model model = test::spatial_slider_crank(false);
  EXPECT_EQ(make_solver(model)->integrators(), (std::vector<std::string>{"adams", "dirk"}));
  try {
    (void)make_solver(model)->integrate(options(1.0, 1, 1e-8, "euler"), {});
    FAIL() << "an unknown integrator was accepted";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "slider_crank.toml: error: the relative solver has no integrator 'euler'; it has adams, dirk");
  }
}

/// A rotor on a soft spring swings through two dozen turns and back: theta = A sin(w t).
TEST(Integration, SwingsThroughManyTurnsAndBack) {
  test::Numbers numbers(61);
  Model model;
  model.file = "rotor.toml";
  model.bodies = {test::ground(), test::rigid_body("rotor", numbers)};
  model.joints = {test::joint(model, "axle", "revolute", 0, 1, numbers)};
  Joint& axle = model.joints[0];
  axle.sides[1].point_L = model.bodies[1].center_of_mass_L;
  const Vec3 axis = axle.sides[1].C.col(2);
  const double inertia = axis.dot(model.bodies[1].inertia_L * axis);
  const double amplitude = 150.0;
  const double rate = 0.8;
  ForceLaw spring;
  spring.stiffness = inertia * rate * rate;
  axle.springs = {{0, spring, 0}};
  axle.start[0].q(0) = 0.0;
  axle.start[0].u(0) = amplitude * rate;
  const auto solver = make_solver(model);
  const Trajectory run = solver->integrate(options(5.0, 50, 1e-11), {});
  for (const Sample& sample : run.samples) {
    EXPECT_NEAR(sample.state.q[0](0), amplitude * std::sin(rate * sample.state.t), 1e-8);
    const double tau = -spring.stiffness * sample.state.q[0](0);
    EXPECT_NEAR(sample.evaluation.joints[0].tau(0), tau, 1e-13 * spring.stiffness * amplitude);
    EXPECT_NO_THROW((void)solver->evaluate(sample.state));
  }
  EXPECT_LT(run.statistics.max_constraint, 1e-15);
}

}  // namespace
}  // namespace concord::relative
