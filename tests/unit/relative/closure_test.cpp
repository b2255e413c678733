#include "relative/closure/closure.h"

#include <gtest/gtest.h>

#include "machines.h"
#include "relative/start/assembly.h"

namespace concord::relative {
namespace {

class MeasuredJoint : public ::testing::TestWithParam<const joints::JointType*> {
 protected:
  MeasuredJoint() : model_(machine()), kinematics_(model_), numbers_(31) {
    const Mobilizer mobilizer(*GetParam());
    q_ = mobilizer.home();
    const VecX away = numbers_.vector(mobilizer.n_u(), 1.1);
    mobilizer.advance(q_.data(), away.data());
    u_ = numbers_.vector(mobilizer.n_u(), 1.4);
    kinematics_.update(q_, u_);
  }

  static Model machine() {
    test::Numbers numbers(12);
    Model model;
    model.bodies = {test::ground(), test::rigid_body("block", numbers)};
    model.joints = {test::joint(model, "J", GetParam()->name.c_str(), 0, 1, numbers)};
    return model;
  }
  const JointPoint& parent() const { return kinematics_.point(JointIndex(0), Side::parent); }
  const JointPoint& child() const { return kinematics_.point(JointIndex(0), Side::child); }

  Model model_;
  Kinematics kinematics_;
  test::Numbers numbers_;
  VecX q_;
  VecX u_;
};

TEST_P(MeasuredJoint, FindsCoordinatesAndSpeedsAgain) {
  const PrescribedMask nothing(6, 0);
  JointMeasure measure(kinematics_.mobilizer(JointIndex(0)), nothing.data());
  VecX q = kinematics_.mobilizer(JointIndex(0)).home();
  VecX u = VecX::Zero(u_.size());
  measure.find_q(parent(), child(), q.data(), JointMeasure::Restart::if_better);
  measure.find_u(parent(), child(), q.data(), u.data());
  if (kinematics_.mobilizer(JointIndex(0)).has_ball() && q.tail<4>().dot(q_.tail<4>()) < 0.0) q.tail<4>() *= -1.0;
  EXPECT_LT((q - q_).norm(), 1e-14);
  EXPECT_LT((u - u_).norm(), 1e-14);
  EXPECT_LT(measure.position_residual().norm(), 1e-15);
  EXPECT_LT(measure.velocity_residual().norm(), 1e-14);
}

TEST_P(MeasuredJoint, ComplementCompletesThePermittedDirections) {
  const int n_u = kinematics_.mobilizer(JointIndex(0)).n_u();
  for (int prescribed_column = -1; prescribed_column < n_u; ++prescribed_column) {
    PrescribedMask prescribed(6, 0);
    if (prescribed_column >= 0) prescribed[prescribed_column] = 1;
    JointMeasure measure(kinematics_.mobilizer(JointIndex(0)), prescribed.data());
    VecX q = q_;
    measure.find_q(parent(), child(), q.data(), JointMeasure::Restart::never);
    const int rows = measure.n_rows();
    EXPECT_EQ(rows, 6 - n_u + (prescribed_column >= 0 ? 1 : 0));
    const MatX T = measure.T().leftCols(rows);
    const Mobilizer& mobilizer = kinematics_.mobilizer(JointIndex(0));
    MatX weighed = T;
    if (mobilizer.couples()) weighed.bottomRows(3) /= mobilizer.length();
    EXPECT_LT((weighed.transpose() * weighed - MatX::Identity(rows, rows)).norm(), 1e-15);
    for (int c = 0; c < n_u; ++c) {
      // Where a speed both displaces and rotates, turns count in lengths of the machine.
      VecX column = measure.motion_at().S.col(c);
      const double along = (T.transpose() * column).norm();
      if (mobilizer.couples()) column.tail<3>() *= mobilizer.length();
      if (c == prescribed_column) {
        EXPECT_GT(along, 0.5 * column.norm());
      } else {
        EXPECT_LT(along, 1e-15);
      }
    }
    if (mobilizer.couples()) {
      EXPECT_EQ(measure.n_linear_rows(), rows);
    } else {
      EXPECT_EQ(T.bottomLeftCorner(3, measure.n_linear_rows()).norm(), 0.0);
    }
  }
}

TEST_P(MeasuredJoint, KeepsTheNumberOfTurnsOfTheFirstGuess) {
  if (GetParam()->name != "revolute" && GetParam()->name != "universal") return;
  const PrescribedMask nothing(6, 0);
  JointMeasure measure(kinematics_.mobilizer(JointIndex(0)), nothing.data());
  VecX q = q_;
  q(0) += 40.0 * M_PI + 0.3;
  measure.find_q(parent(), child(), q.data(), JointMeasure::Restart::if_better);
  EXPECT_NEAR(q(0), q_(0) + 40.0 * M_PI, 1e-13);
}

INSTANTIATE_TEST_SUITE_P(Catalogue, MeasuredJoint, ::testing::ValuesIn(test::all_types()),
                         [](const auto& tested) { return tested.param->name; });

/// The ends of a rod at given places, measured from a first guess of its two turns.
class MeasuredRod : public ::testing::Test {
 protected:
  MeasuredRod() : mobilizer_(*joints::find("distance")), parent_("parent", {}), child_("child", {}) {}

  VecX measure(const Vec3& gap, double q1, double q2) {
    parent_.A = rotation_about(Vec3(Vec3(1, -2, 3).normalized()), 0.9);
    parent_.r = Vec3(0.2, 0.1, -0.4);
    child_.A = parent_.A * rotation_about(Axis::y, 0.7);
    child_.r = parent_.r + parent_.A * gap;
    const PrescribedMask nothing(5, 0);
    JointMeasure measured(mobilizer_, nothing.data());
    VecX q = mobilizer_.home();
    q.head<2>() << q1, q2;
    measured.find_q(parent_, child_, q.data(), JointMeasure::Restart::if_better);
    error_ = measured.position_residual();
    return q;
  }

  Mobilizer mobilizer_;
  JointPoint parent_;
  JointPoint child_;
  Vec6 error_;
};

TEST_F(MeasuredRod, PointsAtItsEndHoweverFarThatIs) {
  for (const double distance : {0.05, 0.4, 1.0, 30.0}) {
    for (const double forward : {1.0, -1.0}) {
      const Vec3 towards = Vec3(0.3, -0.5, 0.8 * forward).normalized();
      measure(distance * towards, 0.3, 0.2);
      EXPECT_LT((Vec3(error_.head<3>()) - (distance - 0.4) * towards).norm(), 1e-6 * std::max(0.4, distance))
          << distance;
    }
  }
}

TEST_F(MeasuredRod, NamesItsPoseOnTheSideOfItsGuess) {
  const double bearing = 0.4;
  const double elevation = 2.5;
  const Vec3 gap = 0.4 * (rotation_about(Axis::x, bearing) * rotation_about(Axis::y, elevation)).col(2);
  const VecX far = measure(gap, bearing + 0.05, elevation - 0.05);
  EXPECT_NEAR(far(0), bearing, 1e-14);
  EXPECT_NEAR(far(1), elevation, 1e-14);
  const VecX q = measure(gap, bearing + M_PI - 0.05, 0.4);
  EXPECT_NEAR(q(0), bearing + M_PI, 1e-14);
  EXPECT_NEAR(q(1), M_PI - elevation, 1e-14);
  EXPECT_LT(error_.norm(), 1e-15);
}

/// A closed loop, and the same opened along the tree's speeds.
class LoopOfFourJoints : public ::testing::TestWithParam<int> {
 protected:
  LoopOfFourJoints() : model_(machine()), equations_(model_) {
    start_ = Assembly(equations_).start();
    speeds_ = test::Numbers(9).vector(equations_.topology().n_tree_u, 0.8);
  }

  static Model machine() {
    Model model = test::spatial_slider_crank(true);
    model.joints[GetParam()].named_as_cut = true;
    return model;
  }

  /// Moves the open tree for a time h with the constant speeds; returns the measured closure.
  void move(double h) {
    VecX q = start_.q;
    for (const Link& link : equations_.topology().links) {
      const Span& joint = equations_.topology().joints[link.joint];
      const VecX step = h * speeds_.segment(joint.first_u, joint.n_u);
      equations_.kinematics().mobilizer(link.joint).advance(q.data() + joint.first_q, step.data());
      const Span& modes = equations_.topology().modes[link.body];
      q.segment(modes.first_q, modes.n_q) += h * speeds_.segment(modes.first_u, modes.n_u);
    }
    VecX u = start_.u;
    u.head(speeds_.size()) = speeds_;
    equations_.move(0.0, q, u);
  }

  Model model_;
  Equations equations_;
  Coordinates start_;
  VecX speeds_;
};

TEST_P(LoopOfFourJoints, VelocityClosureIsPhiTimesSpeeds) {
  move(0.0);
  const VecX expected = equations_.closure().Phi_u() * speeds_;
  EXPECT_LT((equations_.closure().velocity_residual() - expected).norm(), 1e-13);
  EXPECT_GT(expected.norm(), 0.1);
}

TEST_P(LoopOfFourJoints, GapGrowsWithTheVelocityClosure) {
  const double h = 1e-5;
  move(h);
  const VecX ahead = equations_.closure().position_residual();
  move(-h);
  const VecX behind = equations_.closure().position_residual();
  move(0.0);
  EXPECT_LT(((ahead - behind) / (2 * h) - equations_.closure().velocity_residual()).norm(), 1e-8);
}

TEST_P(LoopOfFourJoints, AccelerationClosureIsTheDerivativeOnClosedPaths) {
  // Along the machine's own motion all three closures vanish; the accelerations found must say so too.
  const Evaluated& evaluated = equations_.compute_accelerations(0.0, start_.q, start_.u);
  VecX residual(equations_.closure().n_rows());
  const auto acceleration = [&](JointIndex joint, Side side) {
    return evaluated.accelerations().of_point(joint, side);
  };
  equations_.closure().compute_acceleration_residual(acceleration, evaluated.udot(), residual);
  EXPECT_LT(residual.norm(), 1e-11);
  // And the velocities that they lead to stay closed to second order.
  const VecX udot = evaluated.udot();
  const double h = 1e-5;
  speeds_ = start_.u.head(speeds_.size());
  const auto slip_at = [&](double t) {
    VecX q = start_.q;
    for (const Link& link : equations_.topology().links) {
      const Span& joint = equations_.topology().joints[link.joint];
      const VecX step =
          t * start_.u.segment(joint.first_u, joint.n_u) + 0.5 * t * t * udot.segment(joint.first_u, joint.n_u);
      equations_.kinematics().mobilizer(link.joint).advance(q.data() + joint.first_q, step.data());
      const Span& modes = equations_.topology().modes[link.body];
      q.segment(modes.first_q, modes.n_q) += t * start_.u.segment(modes.first_u, modes.n_u);
    }
    const VecX u = start_.u + t * udot;
    equations_.move(0.0, q, u);
    return VecX(equations_.closure().velocity_residual());
  };
  EXPECT_LT((slip_at(h) - slip_at(-h)).norm() / (2 * h), 1e-5);
}

INSTANTIATE_TEST_SUITE_P(CutAtEach, LoopOfFourJoints, ::testing::Range(0, 4));

TEST(Closure, NamesTheWorstCutJoint) {
  Model model = test::spatial_slider_crank(false);
  test::Numbers numbers(6);
  model.joints.push_back(test::joint(model, "E", "spherical", 0, 3, numbers));
  const Kinematics kinematics(model);
  const Closure closure(kinematics, driven_speeds(model, kinematics.topology()));
  ASSERT_EQ(closure.cuts().size(), 2u);
  VecX rows = VecX::Zero(closure.n_rows());
  rows(closure.n_rows() - 1) = -2.0;
  rows(0) = 1.0;
  EXPECT_EQ(closure.worst_place(rows), "the loop of joint 'E'");
}

}  // namespace
}  // namespace concord::relative
