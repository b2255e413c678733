#include "relative/bodies/machine_size.h"

#include <gtest/gtest.h>

#include "common/joints/revolute.h"
#include "common/joints/translational.h"
#include "machines.h"
#include "relative/rank/scaled_closure.h"

namespace concord::relative {
namespace {

/// A pendulum has one joint point: its length is that of its own mass, in whatever unit.
TEST(MachineLength, IsNeverAUnit) {
  test::Numbers numbers(4);
  Model model;
  model.bodies = {test::ground(), test::rigid_body("bob", numbers)};
  model.joints = {test::joint(model, "hinge", "revolute", 0, 1, numbers)};
  const double length = machine_length(model);
  EXPECT_GT(length, 0.1);
  for (Attachment& side : model.joints[0].sides) side.point_L *= 1024.0;
  model.bodies[1].center_of_mass_L *= 1024.0;
  model.bodies[1].inertia_L *= 1024.0 * 1024.0;
  EXPECT_EQ(machine_length(model), 1024.0 * length);
  const Model crank = test::spatial_slider_crank(false);
  EXPECT_EQ(machine_length(crank), crank.length_scale());
}

TEST(MachineSize, CountsSlidesInTheLengthAndModesByTheirDisplacement) {
  const Model model = test::spatial_slider_crank(true);
  const Topology topology = build_topology(model);
  const MachineSize size(model, topology);
  const double length = model.length_scale();
  EXPECT_EQ(size.length(), length);
  EXPECT_EQ(size.speeds()(topology.joints[0].first_u), 1.0);
  EXPECT_EQ(size.speeds()(topology.joints[3].first_u), length);
  for (int k = 0; k < 3; ++k) {
    double largest = 0.0;
    for (const MassPoint& p : model.bodies[2].modal->mass_points) largest = std::max(largest, p.Psi_t_L.col(k).norm());
    EXPECT_DOUBLE_EQ(size.speeds()(topology.modes[2].first_u + k) * largest, length);
    EXPECT_EQ(size.coordinates()(topology.modes[2].first_q + k), size.speeds()(topology.modes[2].first_u + k));
  }
  EXPECT_EQ(size.coordinates()(topology.joints[0].first_q), 1.0);
  EXPECT_EQ(size.coordinates()(topology.joints[3].first_q), length);
}

TEST(ScaledClosure, HasRowsThatDoNotDependOnTheUnitOfLength) {
  // The same machine in millimetres.
  Model model = test::spatial_slider_crank(false);
  Model scaled = model;
  for (Joint& joint : scaled.joints) {
    for (Attachment& side : joint.sides) side.point_L *= 1000.0;
  }
  scaled.joints[3].start[0].q *= 1000.0;
  const auto matrix = [](const Model& machine) {
    Equations equations(machine);
    const Topology& topology = equations.topology();
    VecX q = VecX::Zero(topology.n_q);
    for (std::size_t k = 0; k < machine.joints.size(); ++k) {
      int first = topology.joints[k].first_q;
      for (const WordStart& word : machine.joints[k].start) {
        q.segment(first, word.q.size()) = word.q;
        first += static_cast<int>(word.q.size());
      }
    }
    equations.move(0.0, q, VecX::Zero(topology.n_u));
    const ScaledClosure closure(equations);
    return closure.rows(closure.free_columns());
  };
  const MatX rows = matrix(model);
  EXPECT_GT(rows.norm(), 1.0);
  EXPECT_LT((rows - matrix(scaled)).norm(), 1e-12);
}

/// The rate of a machine without gravity that a law alone moves, in joint `type`, from rest.
double rate_driven_by(const joints::JointType& type, const TimeFunction& law) {
  Model model;
  model.gravity.setZero();
  model.run.until = 4.0;
  model.bodies.resize(2);
  model.bodies[1].mass = 1.0;
  Joint joint;
  joint.type = &type;
  joint.sides[index(Side::child)].body = 1;
  joint.sides[index(Side::child)].point_L = Vec3(0.5, 0.0, 0.0);
  joint.drivers.push_back({0, law, 0});
  model.joints.push_back(joint);
  return MachineSize(model, build_topology(model)).rate();
}

TEST(MachineRate, OfADrivenTurnIsThatOfItsLaw) {
  const auto rate = [](const TimeFunction& law) { return rate_driven_by(joints::revolute, law); };
  EXPECT_DOUBLE_EQ(rate(ConstantSpeed{3.0, -0.8}), 0.8);
  EXPECT_DOUBLE_EQ(rate(Harmonic{1.0, 0.3, 7.0, 0.2}), 2.1);
  EXPECT_DOUBLE_EQ(rate(SmoothStep{0.1, 0.6, 1.5, 0.5}), 2.0);
  EXPECT_DOUBLE_EQ(rate(Polynomial{{9.0, 0.2, 0.0, 4.0 / 3.0}}), 2.0);  // 3! 4/3 = 2^3
  EXPECT_DOUBLE_EQ(rate(SplineTable({0.0, 0.5, 0.6, 1.0}, {0.0, 0.1, 0.4, 0.4})), 3.0);
  EXPECT_EQ(rate(Polynomial{{9.0}}), 0.25);  // nothing moves: one over the time of the run
}

TEST(MachineRate, OfADrivenSlideCountsLengthsOfTheMachine) {
  const auto rate = [](const TimeFunction& law) { return rate_driven_by(joints::translational, law); };
  EXPECT_DOUBLE_EQ(rate(ConstantSpeed{3.0, -0.8}), 1.6);
  EXPECT_DOUBLE_EQ(rate(Harmonic{1.0, 0.3, 7.0, 0.2}), 4.2);
  EXPECT_DOUBLE_EQ(rate(SmoothStep{0.1, 0.6, 1.5, 0.5}), 4.0);
  EXPECT_DOUBLE_EQ(rate(Polynomial{{9.0, 0.2, 0.0, 2.0 / 3.0}}), 2.0);  // 3! 2/3 / 0.5 = 2^3
  EXPECT_DOUBLE_EQ(rate(SplineTable({0.0, 0.5, 0.6, 1.0}, {0.0, 0.1, 0.4, 0.4})), 6.0);
}

}  // namespace
}  // namespace concord::relative
