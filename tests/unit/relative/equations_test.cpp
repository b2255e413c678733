#include "relative/dynamics/equations.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "machines.h"
#include "relative/start/assembly.h"
#include "relative/start/states.h"

#if !defined(CONCORD_SANITIZED)
namespace {
long allocations = 0;
}
extern "C" void* __libc_malloc(size_t size);  // NOLINT(bugprone-reserved-identifier)
/// Counts what the process allocates: glibc lets a program replace malloc.
extern "C" void* malloc(size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
namespace concord::relative::test {
/// For other tests of this program too.
long allocations_so_far() { return allocations; }
}  // namespace concord::relative::test
#endif

namespace concord::relative {
namespace {

#if !defined(CONCORD_SANITIZED)
TEST(Equations, AllocateNothingInAnEvaluation) {
  for (const bool flexible : {false, true}) {
    std::vector<Model> machines{test::tree_of_all_joints(flexible), test::spatial_slider_crank(flexible)};
    std::vector<Joint>& joints = machines.front().joints;
    const double offset = 1.3 * joints[0].start[0].q(0) - 0.7 * joints[2].start[1].q(0) + 0.4 * joints[7].start[0].q(0);
    machines.front().couplings = {{"G", {{0, 0, 0, 1.3}, {2, 1, 0, -0.7}, {7, 0, 0, 0.4}}, offset, {}}};
    test::release(joints[0]);
    for (const char* type : {"distance", "knee", "knife_edge", "rolling_ball"})
      machines.push_back(test::pair(*test::type_named(type), flexible ? 3 : 0));
    for (Model& model : machines) {
      test::Numbers numbers(47);
      test::add_force_elements(model, numbers);
      for (Joint& joint : model.joints) test::add_springs(joint);
      Equations equations(model);
      const Coordinates start = Assembly(equations).start();
      VecX qdot = VecX::Zero(equations.topology().n_q);
      equations.compute_accelerations(0.0, start.q, start.u);
      const long before = allocations;
      (void)equations.power(equations.compute_accelerations(0.0, start.q, start.u));
      equations.compute_reactions(equations.compute_accelerations(0.0, start.q, start.u));
      equations.compute_qdot(equations.motion(), qdot);
      EXPECT_EQ(allocations - before, 0) << model.name << (flexible ? ", flexible" : ", rigid");
    }
  }
}
#endif

/// Driven only; pushed by everything too; and pushed with a sprung joint cut.
class PowerOfMachine : public ::testing::TestWithParam<const char*> {};

TEST_P(PowerOfMachine, IsTheRateOfEnergy) {
  // Power of drivers, springs and force elements minus dissipation equals the rate of kinetic, potential and strain
  // energy along the motion.
  Model model = test::spatial_slider_crank(true);
  const std::string kind = GetParam();
  if (kind != "driven") {
    test::Numbers numbers(29);
    test::add_force_elements(model, numbers);
    for (Joint& joint : model.joints) test::add_springs(joint);
    model.joints[2].named_as_cut = kind == "cut";
  }
  model.joints[0].start[0].role_q = StartRole::guess;
  model.joints[0].start[0].role_u = StartRole::guess;
  const double q = model.joints[0].start[0].q(0);
  model.joints[0].drivers.push_back({0, Harmonic{q, 0.3, 4.0, 0.0}});
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  const auto energy_at = [&](double t) {
    // One step of the classical fourth-order rule from the start.
    Coordinates c = start;
    const auto rates = [&](double time, const VecX& q_at, const VecX& u_at) {
      const Evaluated& evaluated = equations.compute_accelerations(time, q_at, u_at);
      VecX qdot = VecX::Zero(q_at.size());
      equations.compute_qdot(equations.motion(), qdot);
      return std::pair(qdot, VecX(evaluated.udot()));
    };
    const auto k1 = rates(0, c.q, c.u);
    const auto k2 = rates(t / 2, c.q + t / 2 * k1.first, c.u + t / 2 * k1.second);
    const auto k3 = rates(t / 2, c.q + t / 2 * k2.first, c.u + t / 2 * k2.second);
    const auto k4 = rates(t, c.q + t * k3.first, c.u + t * k3.second);
    c.q += t / 6 * (k1.first + 2 * k2.first + 2 * k3.first + k4.first);
    c.u += t / 6 * (k1.second + 2 * k2.second + 2 * k3.second + k4.second);
    c.t = t;
    return test::energy(model, States(equations).write(equations.move(t, c.q, c.u), {}));
  };
  const double h = 1e-5;
  const double rate = (energy_at(h) - energy_at(-h)) / (2 * h);
  const Evaluated& evaluated = equations.compute_accelerations(0.0, start.q, start.u);
  EXPECT_NEAR(equations.power(evaluated), rate, 1e-6 * std::abs(rate));
}

INSTANTIATE_TEST_SUITE_P(Machines, PowerOfMachine, ::testing::Values("driven", "pushed", "cut"),
                         [](const auto& tested) { return tested.param; });

TEST(Equations, CoordinatesFollowSpeedsWithCutJointsAndModes) {
  const Model model = test::spatial_slider_crank(true);
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  VecX qdot = VecX::Zero(equations.topology().n_q);
  equations.compute_qdot(equations.move(0.0, start.q, start.u), qdot);
  const double h = 1e-6;
  const VecX ahead = start.q + h * qdot;
  const Motion& motion = equations.move(0.0, ahead, start.u);
  // The measured coordinates of the cut joint agree with the integrated ones, and the loop stays closed, to order h^2.
  EXPECT_LT((motion.q() - ahead).norm(), 1e-10);
  EXPECT_LT(equations.closure().position_residual().norm(), 1e-10);
}

/// A pose that is kept is that of the same coordinates, whole turns that are counted apart included.
TEST(Equations, KeepAPoseAsLongAsItIsTheSame) {
  Model model = test::spatial_slider_crank(false);
  model.joints[0].start[0].role_q = StartRole::guess;
  model.joints[0].start[0].role_u = StartRole::guess;
  const double q = model.joints[0].start[0].q(0);
  model.joints[0].drivers.push_back({0, Harmonic{q, 0.3, 4.0, 0.0}});
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  const int driven = equations.topology().joints[0].first_q;
  const auto driven_after = [&](double t, const VecX& speeds) {
    const Motion& motion = equations.move(t, VecX(equations.motion().q()), speeds);
    return std::pair(motion.q()(driven), motion.u()(equations.topology().joints[0].first_u));
  };
  const auto fresh = [&](double t) {
    equations.keep_pose(false);
    const auto found = driven_after(t, start.u);
    equations.keep_pose(true);
    return found;
  };
  (void)equations.move(0.0, start.q, start.u);
  EXPECT_EQ(driven_after(0.0, equations.motion().u()), fresh(0.0));
  const auto later = driven_after(0.02, start.u);
  EXPECT_NE(later, fresh(0.0));
  EXPECT_EQ(later, fresh(0.02));
  VecX turns = equations.kinematics().turns();
  turns(driven) += 1.0;
  equations.count_turns(turns);
  EXPECT_NEAR(driven_after(0.02, equations.motion().u()).first, later.first - 2.0 * EIGEN_PI, 1e-12);
  equations.keep_pose(false);
}

/// Wrenches for accelerations of a pose that the machine has left would be those of no pose.
TEST(Equations, RefuseAccelerationsOfAnotherPose) {
  const Model model = test::spatial_slider_crank(false);
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  const Evaluated& evaluated = equations.compute_accelerations(0.0, start.q, start.u);
  EXPECT_NO_THROW(equations.compute_reactions(evaluated));
  equations.move(0.0, equations.home(), start.u);
  EXPECT_THROW(equations.compute_reactions(evaluated), std::logic_error);
  EXPECT_THROW((void)equations.power(evaluated), std::logic_error);
  const Evaluated& again = equations.compute_accelerations(0.0, start.q, start.u);
  EXPECT_NO_THROW(equations.compute_reactions(again));
  equations.place(0.0, equations.home(), start.u);
  EXPECT_THROW(equations.compute_reactions(again), std::logic_error);
}

}  // namespace
}  // namespace concord::relative
