#include "cartesian/run/stepper.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "cartesian/solver.h"
#include "common/joints/catalogue.h"
#include "common/reading/model_file.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

/// A free rigid body that tumbles without gravity: no constraints, so the method is seen alone.
struct Tumbler {
  Model model;
  Equations equations;
  Dynamics dynamics;
  MotionState start;

  Tumbler() : model(make()), equations(model), dynamics(equations) {
    start.q = VecX::Zero(14);
    start.q(3) = start.q(10) = 1.0;
    start.Y = VecX::Zero(12);
    start.Y.segment<3>(3) = Vec3(1.0, 2.5, -0.7);
    start.Y.segment<3>(9) = Vec3(0.3, -0.2, 2.0);
  }

  static Model make() {
    Model model = testing::make_pair(131, *joints::find("free"), 0, 0);
    model.gravity.setZero();
    return model;
  }
};

std::unique_ptr<Stepper> make_stepper(Tumbler& tumbler, double rtol, bool collocates) {
  const Tolerance tolerance{rtol, 2.0};
  return collocates ? make_collocation_stepper(tumbler.dynamics, tumbler.start, tolerance)
                    : make_ida_stepper(tumbler.dynamics, tumbler.start, tolerance);
}

MotionState run(Tumbler& tumbler, double rtol, bool collocates, long* steps = nullptr) {
  const auto stepper = make_stepper(tumbler, rtol, collocates);
  double reached = 0.0;
  while (reached < 2.0) reached = stepper->step(2.0, 2.0);
  if (steps != nullptr) *steps = stepper->steps();
  return stepper->motion();
}

/// With an order of p, the work of a tolerance 10^4 times smaller grows by 10^(4/p): at order 16 steps are less than
/// twice as many, at order 4 ten times.
TEST(Stepper, CollocationConvergesAtAHighOrder) {
  Tumbler tumbler;
  const MotionState exact = run(tumbler, 1e-14, true);
  long coarse_steps = 0;
  long fine_steps = 0;
  const MotionState coarse = run(tumbler, 1e-8, true, &coarse_steps);
  const MotionState fine = run(tumbler, 1e-12, true, &fine_steps);
  EXPECT_LT((coarse.q - exact.q).norm(), 1e-7);
  EXPECT_LT((fine.q - exact.q).norm(), 1e-11);
  EXPECT_LT(fine_steps, 2 * coarse_steps);
}

/// Outputs within a step do not end it, and the motion there is as exact as at its end.
TEST(Stepper, OutputsDoNotEndSteps) {
  constexpr int kOutputs = 500;
  Tumbler tumbler;
  long steps = 0;
  (void)run(tumbler, 1e-11, true, &steps);
  const auto sampled = make_stepper(tumbler, 1e-11, true);
  const auto exact = make_stepper(tumbler, 1e-14, true);
  double worst = 0.0;
  for (int k = 1; k <= kOutputs; ++k) {
    const double t = k == kOutputs ? 2.0 : 2.0 * k / kOutputs;
    double reached = 0.0;
    while (reached < t) reached = sampled->step(t, 2.0);
    ASSERT_EQ(reached, t);
    for (reached = 0.0; reached < t;) reached = exact->step(t, 2.0);
    worst = std::max(worst, (sampled->motion().q - exact->motion().q).norm());
  }
  EXPECT_EQ(sampled->steps(), steps);
  EXPECT_LT(worst, 1e-10);
}

/// A stop may lie next to the end of a step: time and motion stay together.
TEST(Stepper, StopsBesideTheEndOfAStepMoveNeitherTimeNorMotion) {
  Tumbler tumbler;
  const MotionState exact = run(tumbler, 1e-14, true);
  for (const double apart : {1.0, 10.0, 40.0, 60.0, 90.0, 120.0, 150.0}) {  // round-off of the time
    const auto stepper = make_stepper(tumbler, 1e-11, true);
    double reached = 0.0;
    while (reached < 2.0) {
      reached = stepper->step(2.0, 2.0);
      const double beside = std::min(2.0, reached * (1.0 + apart * std::numeric_limits<double>::epsilon()));
      reached = stepper->step(beside, 2.0);
      ASSERT_EQ(reached, beside) << apart;
      ASSERT_LT(stepper->steps(), 2000) << apart;
    }
    EXPECT_LT((stepper->motion().q - exact.q).norm(), 1e-8) << apart;
  }
}

/// Each of them lies within round-off of the one before, all of them do not: the motion may not stay behind.
TEST(Stepper, ManyStopsInARowMoveTheMotionWithTheTime) {
  Tumbler tumbler;
  const auto stepper = make_stepper(tumbler, 1e-11, true);
  double reached = stepper->step(2.0, 2.0);
  const MotionState before = stepper->motion();
  const double begin = reached;
  constexpr int kStops = 3000;
  for (int k = 0; k < kStops; ++k) {
    const double beside = reached * (1.0 + 100.0 * std::numeric_limits<double>::epsilon());
    reached = stepper->step(beside, 2.0);
    ASSERT_EQ(reached, beside);
  }
  const double moved = (stepper->motion().q - before.q).norm();
  EXPECT_GT(moved, 0.5 * (reached - begin)) << "at rates of 1.3 and 1.0 of Euler parameters";
}

/// The most looks at one step of a block that swings on a slide, past the end of its spring `beside` the slide.
int most_looks(double beside) {
  const Model model = parse_model(fmt::format(R"toml(format = 1
[[body]]
name = "block"
mass = 1.3
inertia = [0.01, 0.012, 0.014]
[[joint]]
name = "slide"
type = "translational"
parent = "ground"
child = "block"
[[line_spring]]
name = "cord"
parent = {{ body = "ground", point = [{}, 0, 0] }}
child = "block"
stiffness = 40
free = 0
[run]
until = 2
)toml",
                                              beside),
                                  "block.toml");
  Equations equations(model);
  Dynamics dynamics(equations);
  MotionState start{VecX::Zero(7), VecX::Zero(6), 0.0};
  start.q(2) = 0.4;
  start.q(3) = 1.0;
  const auto stepper = make_collocation_stepper(dynamics, start, {1e-11, 2.0});
  int most = 0;
  int looks = 0;
  for (double reached = 0.0; reached < 2.0;) {
    reached = stepper->step(2.0, 2.0);
    ++looks;
    if (stepper->is_within_step()) continue;
    most = std::max(most, looks);
    looks = 0;
  }
  return most;
}

TEST(Stepper, LooksCloselyWhereALineMayVanish) {
  EXPECT_EQ(most_looks(10.0), 4);
  EXPECT_EQ(most_looks(1e-6), 16);
}

/// What sweeps leave of the motion, where they converge slowly, does not grow from step to step.
TEST(Stepper, SweepsConvergeBesideStiffModes) {
  const Model model = read_model(CONCORD_DATA "/models/slider_crank_spatial_flexible.toml");
  const auto solver = make_solver(model);
  const auto run_at = [&](double rtol) {
    RunOptions options;
    options.until = 0.3;
    options.samples = 80;
    options.rtol = rtol;
    return solver->integrate(options, {});
  };
  const Trajectory exact = run_at(1e-11);
  const std::vector<double> tolerances = {2e-8, 1.6e-8, 1.2e-8, 1e-8};
  double digits = 0.0;
  for (const double rtol : tolerances) {
    const Trajectory loose = run_at(rtol);
    double worst = 0.0;
    double largest = 0.0;
    for (std::size_t k = 0; k < exact.samples.size(); ++k) {
      for (std::size_t body = 0; body < exact.samples[k].state.bodies.size(); ++body) {
        const VecX& rates = exact.samples[k].state.bodies[body].adot;
        worst = std::max(worst, (loose.samples[k].state.bodies[body].adot - rates).norm());
        largest = std::max(largest, rates.norm());
      }
    }
    digits -= std::log10(worst / largest) / static_cast<double>(tolerances.size());
  }
  EXPECT_GT(digits, 9.1);
}

TEST(Stepper, IdaConvergesToTheSameMotion) {
  Tumbler tumbler;
  const MotionState exact = run(tumbler, 1e-14, true);
  const MotionState by_ida = run(tumbler, 1e-10, false);
  EXPECT_LT((by_ida.q - exact.q).norm(), 1e-7);
}

}  // namespace
}  // namespace concord::cartesian
