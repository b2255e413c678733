#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>

#include "cartesian/dynamics/dynamics.h"
#include "cartesian/rank/closing.h"
#include "common/joints/catalogue.h"
#include "machines.h"

#ifndef CONCORD_SANITIZED  // sanitizers have a malloc of their own

namespace {
std::atomic<long> n_allocations{0};
}

extern "C" void* __libc_malloc(std::size_t size);  // NOLINT(bugprone-reserved-identifier)
extern "C" void* malloc(std::size_t size) noexcept {
  ++n_allocations;
  return __libc_malloc(size);
}

namespace concord::cartesian {
namespace {

Model sprung_and_coupled() {
  Model model = testing::make_pair(121, *joints::find("cylindrical"), 2, 3);
  JointSpring spring;
  spring.law.stiffness = 20.0;
  spring.law.upper = SmoothStop{.at = 0.1, .stiffness = 300.0, .damping = 2.0, .width = 0.05};
  model.joints[0].springs.push_back(spring);
  model.couplings.push_back({"thread", {{0, 0, 0, 1.0}, {0, 1, 0, 0.1}}, 0.0, {}});
  return model;
}

/// Memory is laid out when the model is loaded: what an integrator does in a step leaves it alone.
TEST(Allocation, AnEvaluationAProjectionAndALookForEventsAllocateNothing) {
  const Model model = sprung_and_coupled();
  Equations equations(model);
  Dynamics dynamics(equations);
  testing::Numbers numbers(122);
  VecX q;
  VecX Y;
  bool closed = false;
  for (int guess = 0; guess < 10 && !closed; ++guess) {  // a guess far off may end on the branch of turned axes
    q = numbers.matrix(equations.layout().n_q(), 1, 0.3);
    Y = numbers.matrix(equations.layout().n_Y(), 1, 1.5);
    equations.count_turns_from({VecX::Zero(2)});
    closed = close_machine(equations, 0.0, Hold::constraints, Modes::kept, q, Y).closed;
  }
  ASSERT_TRUE(closed);
  q(0) += 1e-6;
  VecX scratch = q;
  VecX speeds = Y;
  dynamics.project(dynamics.solve_at(0.0, q, Y, Pivots::fresh), 0.0, scratch, speeds);  // KLU makes its room
  scratch = q;
  const long before = n_allocations;
  const Solution& solution = dynamics.solve_at(0.0, q, Y, Pivots::kept);
  EXPECT_EQ(n_allocations - before, 0) << "an evaluation";
  (void)equations.power_of(solution.lambda());
  EXPECT_EQ(n_allocations - before, 0) << "the power";
  (void)equations.applied().event_functions(equations.moving_constraints(), 0.0, q, Y);
  EXPECT_EQ(n_allocations - before, 0) << "a look for events";
  dynamics.project(solution, 0.0, scratch, speeds);
  EXPECT_EQ(n_allocations - before, 0) << "a projection";
  EXPECT_GT((scratch - q).norm(), 1e-8);
}

}  // namespace
}  // namespace concord::cartesian

#endif
