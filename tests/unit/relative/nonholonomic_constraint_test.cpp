#include "relative/closure/nonholonomic_constraint.h"

#include <gtest/gtest.h>

#include "common/decompositions.h"
#include "common/joints/rolling_ball.h"
#include "machines.h"
#include "relative/solver.h"

namespace concord::relative {
namespace {

std::vector<const joints::JointType*> slipping_types() {
  std::vector<const joints::JointType*> types = test::all_types();
  std::erase_if(types, [](const joints::JointType* type) { return type->permits_speeds.empty(); });
  return types;
}

class RollingType : public ::testing::TestWithParam<const joints::JointType*> {
 protected:
  RollingType() : mobilizer_(*GetParam(), 1.7), speeds_(*GetParam(), mobilizer_), numbers_(15) {
    q_ = mobilizer_.home();
    const VecX away = numbers_.vector(mobilizer_.n_u(), 1.3);
    mobilizer_.advance(q_.data(), away.data());
  }

  /// What of u is not permitted at q.
  VecX slip(const VecX& q, const VecX& u) {
    JointMotion at;
    mobilizer_.evaluate(q.data(), u.data(), at);
    speeds_.evaluate(at, "J");
    const MatX C = speeds_.C();
    return C * least_squares(C, u);
  }

  Mobilizer mobilizer_;
  NonholonomicConstraint speeds_;
  test::Numbers numbers_;
  VecX q_;
};

TEST(RelativeNonholonomicConstraint, IsThatOfAPlanetAsOfABead) {
  for (const double radius : {7.3e-9, 1.37e-3, 0.73, 1.37e6, 3.31e7, 7.7e9, 1.37e11, 3.1e12, 5.9e12}) {
    const joints::JointType type = joints::rolling_ball_of({radius});
    const Mobilizer mobilizer(type, 1.3 * radius);
    EXPECT_NO_THROW(NonholonomicConstraint(type, mobilizer)) << radius;
  }
}

TEST(RelativeNonholonomicConstraint, IsThatOfAPlanetInASmallMachine) {
  for (const double radius : {1.37e6, 3.31e7, 7.7e9, 1.37e11, 3.1e14}) {
    const joints::JointType type = joints::rolling_ball_of({radius});
    const Mobilizer mobilizer(type, 0.23);
    EXPECT_NO_THROW(NonholonomicConstraint(type, mobilizer)) << radius;
  }
}

TEST_P(RollingType, StaysPermittedAlongItsMotion) {
  ASSERT_EQ(speeds_.n_rows(), mobilizer_.n_u() - static_cast<int>(GetParam()->permits_speeds.size()));
  VecX u = numbers_.vector(mobilizer_.n_u(), 1.5);
  u -= slip(q_, u);
  EXPECT_LT(slip(q_, u).norm(), 1e-14);
  JointMotion at;
  mobilizer_.evaluate(q_.data(), u.data(), at);
  speeds_.evaluate(at, "J");
  const MatX C = speeds_.C();
  VecX udot = numbers_.vector(mobilizer_.n_u(), 2.0);
  udot -= C * solve_square(C.transpose() * C, C.transpose() * udot + speeds_.bias());
  const auto slip_at = [&](double h) {
    VecX q = q_;
    const VecX step = h * u + 0.5 * h * h * udot;
    mobilizer_.advance(q.data(), step.data());
    return slip(q, u + h * udot);
  };
  const double h = 1e-5;
  EXPECT_LT((slip_at(h) - slip_at(-h)).norm() / (2 * h), 1e-8);
}

INSTANTIATE_TEST_SUITE_P(Catalogue, RollingType, ::testing::ValuesIn(slipping_types()),
                         [](const auto& tested) { return tested.param->name; });

TEST(NonholonomicConstraint, RefuseAPageThatContradictsItself) {
  joints::JointType type = *joints::find("knife_edge");
  type.permits_speeds[0] = joints::SpeedAlong{Side::parent, Axis::z};
  const Mobilizer mobilizer(type);
  EXPECT_THROW((NonholonomicConstraint{type, mobilizer}), std::invalid_argument);
}

/// A body on a plane of any tilt, at a joint of the type with the plane as parent.
Model on_a_plane(const joints::JointType& type, test::Numbers& numbers, double mass, const Vec3& center_C,
                 const Mat3& I_C) {
  Model model;
  model.file = "plane.toml";
  model.gravity = Vec3(1.9, -8.8, 3.1);
  Body body;
  body.name = "body";
  model.bodies = {test::ground(), body};
  model.joints = {test::joint(model, "J", type.name.c_str(), 0, 1, numbers)};
  const Attachment& child = model.joints[0].on(Side::child);
  model.bodies[1].mass = mass;
  model.bodies[1].center_of_mass_L = child.point_L + child.C * center_C;
  model.bodies[1].inertia_L = child.C * I_C * child.C.transpose();
  return model;
}

/// Chaplygin's sleigh, its centre of mass ahead of the edge by a: v' = a omega^2 + g_x,
/// (I + m a^2) omega' = -m a (v omega - g_y), and the edge holds it with m (v omega + a omega' - g_y).
TEST(NonholonomicConstraint, ChaplyginsSleighMovesAsInTheBook) {
  test::Numbers numbers(3);
  const double m = 1.7;
  const double a = 0.23;
  const double I = 0.061;
  Model model =
      on_a_plane(*joints::find("knife_edge"), numbers, m, Vec3(a, 0.0, 0.31), Vec3(0.05, 0.04, I).asDiagonal());
  Joint& joint = model.joints[0];
  const double angle = 0.8;
  const double v = 1.4;
  const double omega = -2.1;
  joint.start[2].q(0) = angle;
  joint.start[2].u(0) = omega;
  joint.start[0].u(0) = v * std::cos(angle);
  joint.start[1].role_u = StartRole::guess;
  joint.start[1].u(0) = 0.3;  // wrong: it follows from the edge
  const std::unique_ptr<Solver> solver = make_solver(model);
  const State state = solver->assemble();
  EXPECT_NEAR(state.u[0](1), v * std::sin(angle), 1e-14);
  const Evaluation evaluation = solver->evaluate(state);
  const Mat3 edge = joint.on(Side::parent).C * rotation_about(Axis::z, angle);
  const Vec3 g = edge.transpose() * model.gravity;
  const double omegadot = -m * a * (v * omega - g.y()) / (I + m * a * a);
  const double vdot = a * omega * omega + g.x();
  EXPECT_NEAR((edge.transpose() * evaluation.bodies[1].omegadot).z(), omegadot, 1e-12);
  const Vec3 arm = -test::rotation_of(state.bodies[1]) * joint.on(Side::child).point_L;
  const Vec3 spin = omega * edge.col(2);
  const Vec3 at_edge = evaluation.bodies[1].vdot - omegadot * edge.col(2).cross(arm) - spin.cross(spin.cross(arm));
  EXPECT_LT((edge.transpose() * at_edge - Vec3(vdot, v * omega, 0.0)).norm(), 1e-12);
  const Wrench& reaction = evaluation.joints[0].reaction_on(Side::child).in_C;
  EXPECT_NEAR(reaction.force.y(), m * (v * omega + a * omegadot - g.y()), 1e-12);
  EXPECT_NEAR(reaction.force.x(), 0.0, 1e-12);
  EXPECT_NEAR(reaction.torque.z(), 0.0, 1e-12);
  const RankReport report = solver->rank(state);
  EXPECT_EQ(report.constraints, 4);
  EXPECT_EQ(report.degrees_of_freedom, 2);
  EXPECT_EQ(solver->tangent(state).cols(), 2);
}

Model ball(test::Numbers& numbers, double m, double r) {
  return on_a_plane(*joints::find("rolling_ball"), numbers, m, Vec3::Zero(), 0.4 * m * r * r * Mat3::Identity());
}

TEST(NonholonomicConstraint, BallRollsDownAtFiveSevenths) {
  test::Numbers numbers(8);
  const double m = 0.9;
  Model model = ball(numbers, m, 0.25);
  for (int slide : {0, 1}) model.joints[0].start[slide].role_u = StartRole::guess;
  const std::unique_ptr<Solver> solver = make_solver(model);
  const State state = solver->assemble();
  const Evaluation evaluation = solver->evaluate(state);
  const Mat3& plane = model.joints[0].on(Side::parent).C;
  const Vec3 g = plane.transpose() * model.gravity;
  const BodyState& body = state.bodies[1];
  const Vec3 omega = plane.transpose() * body.omega;
  EXPECT_NEAR(state.u[0](0), 0.25 * omega.y(), 1e-14);
  EXPECT_NEAR(state.u[0](1), -0.25 * omega.x(), 1e-14);
  const Vec3 arm = test::rotation_of(body) * model.joints[0].on(Side::child).point_L;
  const Vec3 center =
      evaluation.bodies[1].vdot + evaluation.bodies[1].omegadot.cross(arm) + body.omega.cross(body.omega.cross(arm));
  EXPECT_LT((plane.transpose() * center - 5.0 / 7.0 * Vec3(g.x(), g.y(), 0.0)).norm(), 1e-12);
  const Vec3 held = plane.transpose() * evaluation.joints[0].reaction_on(Side::child).in_global.force;
  EXPECT_LT((held - m * Vec3(-2.0 / 7.0 * g.x(), -2.0 / 7.0 * g.y(), -g.z())).norm(), 1e-12);
  EXPECT_EQ(solver->rank(state).degrees_of_freedom, 3);
}

/// On a table that turns at Omega the centre's velocity turns at 2/7 Omega, wherever it is and however the ball spins.
TEST(NonholonomicConstraint, BallOnATurntableCirclesAtTwoSeventhsOfItsRate) {
  test::Numbers numbers(4);
  const double Omega = 2.6;
  Model model = ball(numbers, 0.9, 0.25);
  Body table = test::rigid_body("table", numbers);
  model.bodies.push_back(table);
  Joint hinge = test::joint(model, "hinge", "revolute", 0, 2, numbers);
  hinge.drivers = {{0, ConstantSpeed{0.3, Omega}, 0}};
  hinge.start[0].role_q = hinge.start[0].role_u = StartRole::unsaid;
  const Mat3& axes = hinge.on(Side::parent).C;
  model.gravity = -9.81 * axes.col(2);
  Joint& contact = model.joints[0];
  contact.sides[0] = hinge.on(Side::child);  // the table's plane, its axis normal to it
  contact.sides[0].body = 2;
  contact.sides[0].point_L += contact.sides[0].C * Vec3(0.2, -0.1, 0.4);
  for (int slide : {0, 1}) contact.start[slide].role_u = StartRole::guess;
  model.joints.push_back(hinge);
  RunOptions options;
  options.until = 1.5;
  options.samples = 6;
  for (const bool cut : {false, true}) {
    // Cut at the contact, with a free joint to carry the ball.
    if (cut) {
      model.joints[0].named_as_cut = true;
      Joint flight = test::joint(model, "flight", "free", 0, 1, numbers);
      test::release(flight);
      model.joints.push_back(flight);
      model.bodies[1].pose_guess = Pose{};
    }
    const Trajectory run = make_solver(model)->integrate(options, {});
    const auto velocity = [&](const State& state) {
      const BodyState& body = state.bodies[1];
      const Vec3 arm = test::rotation_of(body) * model.joints[0].on(Side::child).point_L;
      return Vec3(body.v + body.omega.cross(arm));
    };
    const Vec3 first = velocity(run.samples.front().state);
    EXPECT_GT(first.norm(), 0.3);
    for (const Sample& sample : run.samples) {
      const Mat3 turned = axes * rotation_about(Axis::z, 2.0 / 7.0 * Omega * sample.state.t) * axes.transpose();
      EXPECT_LT((velocity(sample.state) - turned * first).norm(), 1e-9) << sample.state.t << cut;
    }
    EXPECT_LT(run.statistics.max_constraint, 1e-13);
  }
}

TEST(NonholonomicConstraint, AsManySpeedsAreKeptAsVelocitiesAreFree) {
  test::Numbers numbers(3);
  const Model model = on_a_plane(*joints::find("knife_edge"), numbers, 1.0, Vec3(0.1, 0.0, 0.2), Mat3::Identity());
  try {
    (void)make_solver(model)->assemble();
    FAIL() << "three speeds of a sleigh were kept";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what())
                  .find("contradict each other: with slide_x, slide_y and turn_z of joint 'J' as kept, the speed of "
                        "slide_y of joint 'J' is -0.249544111, where 1.61040412 is kept"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace concord::relative
