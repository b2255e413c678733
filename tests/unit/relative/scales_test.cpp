#include "relative/scales.h"

#include <gtest/gtest.h>

#include "machines.h"

namespace concord::relative {
namespace {

TEST(Scales, MeasureSlidesByTheLengthAndModesByTheirDisplacement) {
  const Model model = test::spatial_slider_crank(true);
  const Topology topology = build_topology(model);
  const Scales scales(model, topology);
  const double length = model.length_scale();
  EXPECT_EQ(scales.length(), length);
  EXPECT_EQ(scales.speeds()(topology.joints[0].first_u), 1.0);
  EXPECT_EQ(scales.speeds()(topology.joints[3].first_u), length);
  for (int k = 0; k < 3; ++k) {
    double largest = 0.0;
    for (const MassPoint& p : model.bodies[2].modal->mass_points) largest = std::max(largest, p.Psi_t_L.col(k).norm());
    EXPECT_DOUBLE_EQ(scales.speeds()(topology.modes[2].first_u + k) * largest, length);
  }
}

TEST(Scales, MakeTheClosureIndependentOfTheUnitOfLength) {
  // The same machine in millimetres.
  Model model = test::spatial_slider_crank(false);
  Model scaled = model;
  for (Joint& joint : scaled.joints) {
    for (Attachment& side : joint.sides) side.point_L *= 1000.0;
  }
  scaled.joints[3].start[0].q *= 1000.0;
  const auto matrix = [](const Model& machine) {
    const Kinematics shape(machine);
    const Topology& topology = shape.topology();
    Kinematics kinematics(machine);
    VecX q = VecX::Zero(topology.n_q);
    for (std::size_t k = 0; k < machine.joints.size(); ++k) {
      int first = topology.joints[k].first_q;
      for (const WordStart& word : machine.joints[k].start) {
        q.segment(first, word.q.size()) = word.q;
        first += static_cast<int>(word.q.size());
      }
    }
    VecX u = VecX::Zero(topology.n_u);
    kinematics.update(q, u);
    Closure closure(kinematics, driven_speeds(machine, topology));
    closure.measure(q, u);
    return Scales(machine, topology).scaled(closure.Phi_u(), closure);
  };
  EXPECT_LT((matrix(model) - matrix(scaled)).norm(), 1e-12);
}

}  // namespace
}  // namespace concord::relative
