#include "relative/bodies/velocity_transformation.h"

#include <gtest/gtest.h>

#include "machines.h"
#include "relative/bodies/exponential_map.h"
#include "relative/start/assembly.h"

namespace concord::relative {
namespace {

/// A machine at its start, and the same a little earlier or later along qdot = N(q) u.
class MovingMachine : public ::testing::TestWithParam<bool> {
 protected:
  MovingMachine() : model_(test::tree_of_all_joints(GetParam())), equations_(model_), kinematics_(model_) {
    const Coordinates start = Assembly(equations_).start();
    q_ = start.q;
    u_ = start.u;
    kinematics_.update(q_, u_);
  }

  Kinematics moved(double h) const {
    VecX q = q_;
    for (const Link& link : equations_.topology().links) {
      const Span& joint = equations_.topology().joints[link.joint];
      const VecX step = h * u_.segment(joint.first_u, joint.n_u);
      kinematics_.mobilizer(link.joint).advance(q.data() + joint.first_q, step.data());
      const Span& modes = equations_.topology().modes[link.body];
      q.segment(modes.first_q, modes.n_q) += h * u_.segment(modes.first_u, modes.n_u);
    }
    Kinematics kinematics(model_);
    kinematics.update(q, u_);
    return kinematics;
  }

  Model model_;
  Equations equations_;
  Kinematics kinematics_;
  VecX q_;
  VecX u_;
};

constexpr double kStep = 1e-5;

TEST_P(MovingMachine, VelocitiesAreDerivativesOfPoses) {
  const Kinematics ahead = moved(kStep);
  const Kinematics behind = moved(-kStep);
  for (BodyIndex i(1); i < static_cast<int>(model_.bodies.size()); ++i) {
    const Vec3 v = (ahead.body(i).r - behind.body(i).r) / (2 * kStep);
    const Vec3 omega = rotation_vector(ahead.body(i).A * behind.body(i).A.transpose()) / (2 * kStep);
    EXPECT_LT((kinematics_.body(i).v - v).norm(), 2e-8) << model_.bodies[i].name;
    EXPECT_LT((kinematics_.body(i).omega - omega).norm(), 2e-8) << model_.bodies[i].name;
  }
}

TEST_P(MovingMachine, ExplicitBMapsSpeedsToBodyVelocities) {
  EXPECT_LT((kinematics_.explicit_B() * u_ - kinematics_.Y()).norm(), 1e-13 * kinematics_.Y().norm());
}

TEST_P(MovingMachine, BdotIsTheDerivativeOfB) {
  const VecX expected = (moved(kStep).explicit_B() - moved(-kStep).explicit_B()) / (2 * kStep) * u_;
  EXPECT_LT((kinematics_.Bdot_u() - expected).norm(), 1e-8 * expected.norm());
}

TEST_P(MovingMachine, JointPointsOfBothSidesObeyTheMotion) {
  for (const JointIndex k : upward<JointIndex>(model_.joints.size())) {
    const JointPoint& parent = kinematics_.point(k, Side::parent);
    const JointPoint& child = kinematics_.point(k, Side::child);
    const JointMotion& motion = kinematics_.joint_motion(k);
    EXPECT_LT((parent.A.transpose() * (child.r - parent.r) - motion.d).norm(), 1e-14);
    EXPECT_LT((parent.A.transpose() * child.A - motion.R).norm(), 1e-14);
    EXPECT_LT((relative_velocity(parent, child) - motion.v_rel).norm(), 1e-13);
  }
}

INSTANTIATE_TEST_SUITE_P(Trees, MovingMachine, ::testing::Bool(),
                         [](const auto& tested) { return tested.param ? "flexible" : "rigid"; });

TEST(Shift, MovesMotionsAndWrenchesWithEqualPower) {
  test::Numbers numbers(2);
  const Vec6 V = numbers.vector(6, 1.0);
  const Vec6 w = numbers.vector(6, 1.0);
  const Vec3 e = numbers.vector(1.0);
  EXPECT_NEAR(w.dot(shift_motion(V, e)), shift_wrench(w, e).dot(V), 1e-15);
}

}  // namespace
}  // namespace concord::relative
