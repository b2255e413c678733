#include "compare/audit/motion_audit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include "common/joints/catalogue.h"
#include "common/rotation.h"
#include "compare/audit/balance.h"
#include "compare/quantities/needs.h"

namespace concord::compare {
namespace {

/// Two bodies on hinges of their own with tilted axes, off their origins; the second hinge sits on the first body. The
/// angles are given as functions of time by hand, with their rates; nothing of it comes from a solver.
struct TwoHinges {
  Model model;
  State state;
  Evaluation evaluation;
  static constexpr double kTime = 0.37;

  TwoHinges() {
    model.gravity = Vec3(0.0, -3.0, -9.0);
    model.bodies.resize(3);
    model.bodies[0].name = "ground";
    for (int body = 1; body < 3; ++body) {
      model.bodies[body].name = body == 1 ? "arm" : "tip";
      model.bodies[body].mass = 1.3;
      model.bodies[body].inertia_L = Vec3(0.2, 0.3, 0.4).asDiagonal();
    }
    model.joints.resize(2);
    model.joints[0].name = "A";
    model.joints[1].name = "B";
    model.joints[0].sides = {Attachment{0, Vec3(0.3, -0.4, 0.2), rotation_about(Vec3(1, 2, 2) / 3.0, 0.6)},
                             Attachment{1, Vec3(-0.2, 0.1, 0.3), rotation_about(Vec3(2, -1, 2) / 3.0, -0.7)}};
    model.joints[1].sides = {Attachment{1, Vec3(0.5, 0.2, -0.1), rotation_about(Vec3(2, 2, -1) / 3.0, 0.9)},
                             Attachment{2, Vec3(0.1, -0.3, 0.2), rotation_about(Vec3(-1, 2, 2) / 3.0, 1.2)}};
    for (Joint& joint : model.joints) joint.type = joints::find("revolute");
    state.t = kTime;
    state.bodies.resize(3);
    evaluation.bodies.resize(3);
    for (int body = 0; body < 3; ++body) {
      state.bodies[body].a = state.bodies[body].adot = evaluation.bodies[body].addot = VecX(0);
    }
    state.q.resize(2);
    state.u.resize(2);
    evaluation.joints.resize(2);
    hinge(0, 1, 0.8, 2.1, -4.5);
    hinge(1, 2, -7.1, -1.6, 3.2);  // more than a turn away
  }

  /// Puts the child of joint k where the angle q is, with rate u and acceleration udot: its velocity and acceleration
  /// by the rules of relative motion about the hinge's axis.
  void hinge(int k, int body, double q, double u, double udot) {
    const Attachment& on_parent = model.joints[k].sides[0];
    const Attachment& on_child = model.joints[k].sides[1];
    const BodyState& parent = state.bodies[on_parent.body];
    const BodyAcceleration& of_parent = evaluation.bodies[on_parent.body];
    const Mat3 A_parent = rotation_of(parent.p);
    const Vec3 axis = A_parent * on_parent.C.col(2);
    const Mat3 A = A_parent * on_parent.C * rotation_about(Axis::z, q) * on_child.C.transpose();
    const Vec3 lever = A_parent * on_parent.point_L;
    const Vec3 arm = -(A * on_child.point_L);
    BodyState& child = state.bodies[body];
    BodyAcceleration& of_child = evaluation.bodies[body];
    const Eigen::Quaterniond turned(A);
    child.p << turned.w(), turned.vec();
    child.omega = parent.omega + u * axis;
    of_child.omegadot = of_parent.omegadot + udot * axis + parent.omega.cross(u * axis);
    child.r = parent.r + lever + arm;
    child.v = parent.v + parent.omega.cross(lever) + child.omega.cross(arm);
    of_child.vdot = of_parent.vdot + of_parent.omegadot.cross(lever) + parent.omega.cross(parent.omega.cross(lever)) +
                    of_child.omegadot.cross(arm) + child.omega.cross(child.omega.cross(arm));
    state.q[k] = VecX::Constant(1, q);
    state.u[k] = VecX::Constant(1, u);
  }

  [[nodiscard]] AuditFinding finding(AuditRule rule) const {
    MotionAudit audit(model);
    audit.add(state, evaluation);
    AuditFinding worst;
    const AuditScales none{};
    for (const auto* entities : {&audit.joints(), &audit.couplings()}) {
      for (const AuditEntity& entity : *entities) keep_worse(worst, entity.worst(rule, none, none));
    }
    return worst;
  }
};

TEST(MotionAudit, MotionsByHandObeyTheirJoints) {
  const TwoHinges right;
  const AuditFinding found = right.finding(AuditRule::kinematics);
  EXPECT_GT(found.digits, 11.0) << found.text();
}

/// A fault of a relative size of 1e-5 must be seen in the row that is there for it.
void expect_row(const TwoHinges& bench, AuditRule rule, const std::string& where, const std::string& row) {
  const AuditFinding found = bench.finding(rule);
  EXPECT_LT(found.digits, kAuditByDifferences) << found.text();
  EXPECT_EQ(found.where, where) << found.text();
  EXPECT_EQ(found.row.substr(0, row.size()), row) << found.text();
}

TEST(MotionAudit, SeesAPlaceAVelocityAndAnAccelerationOffTheHinge) {
  const Vec3 askew(1e-5, -2e-5, 3e-5);
  const auto spoiled = [](const std::function<void(TwoHinges&)>& spoil) {
    TwoHinges bench;
    spoil(bench);
    return bench;
  };
  const AuditRule rule = AuditRule::kinematics;
  expect_row(spoiled([&](TwoHinges& at) { at.state.bodies[2].r += askew; }), rule, "B", "place along");
  expect_row(spoiled([&](TwoHinges& at) { at.state.bodies[2].v += askew; }), rule, "B", "velocity along");
  expect_row(spoiled([&](TwoHinges& at) { at.state.bodies[2].omega += askew; }), rule, "B", "velocity");
  expect_row(spoiled([&](TwoHinges& at) { at.evaluation.bodies[2].vdot += 3.0 * askew; }), rule, "B",
             "acceleration along");
  expect_row(spoiled([&](TwoHinges& at) { at.evaluation.bodies[2].omegadot += 10.0 * askew; }), rule, "B",
             "acceleration");
}

TEST(MotionAudit, AnAccelerationAlongWhatThePermittedAllowIsNoFault) {
  TwoHinges bench;
  bench.hinge(1, 2, -7.1, -1.6, 25.0);
  EXPECT_GT(bench.finding(AuditRule::kinematics).digits, 11.0);
}

/// A law that is q, u and udot of the second hinge at the time of the state.
Polynomial law_of(double q, double u, double udot) {
  const double t = TwoHinges::kTime;
  return {{q - u * t + 0.5 * udot * t * t, u - udot * t, 0.5 * udot}};
}

TEST(MotionAudit, ADrivenCoordinateFollowsItsLawAndBothItsRates) {
  const auto driven_by = [](const Polynomial& law) {
    TwoHinges bench;
    bench.model.joints[1].drivers = {{0, law}};
    return bench;
  };
  const AuditFinding right = driven_by(law_of(-7.1, -1.6, 3.2)).finding(AuditRule::driver_law);
  EXPECT_GT(right.digits, 11.0) << right.text();
  const AuditRule rule = AuditRule::driver_law;
  expect_row(driven_by(law_of(-7.1 + 1e-4, -1.6, 3.2)), rule, "B", "turn_z");
  expect_row(driven_by(law_of(-7.1, -1.6 + 1e-4, 3.2)), rule, "B", "speed of turn_z");
  expect_row(driven_by(law_of(-7.1, -1.6, 3.2 + 1e-3)), rule, "B", "acceleration of turn_z");
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(driven_by(law_of(-7.1, -1.6, none)).finding(rule).digits, 0.0) << "by a law that gives no number";
}

/// A rod on two turns about one place of ground, its free end on the tip: near the axis of its first turn that turn is
/// read from next to nothing. `off`: by how much the tip is off its place [of a metre].
AuditFinding finding_near_a_gimbal_pose(double away, double off, double udot_off) {
  Model model;
  model.bodies.resize(2);
  model.bodies[0].name = "ground";
  model.bodies[1].name = "tip";
  model.bodies[1].mass = 1.3;
  model.bodies[1].inertia_L = Vec3(0.2, 0.3, 0.4).asDiagonal();
  model.joints.resize(1);
  Joint& joint = model.joints[0];
  joint.name = "rod";
  joint.own_type =
      std::make_shared<const joints::JointType>(joints::find("universal_spherical")->with_parameters({0.5}));
  joint.type = joint.own_type.get();
  joint.sides = {Attachment{0, Vec3(0.3, -0.4, 0.2), rotation_about(Vec3(1, 2, 2) / 3.0, 0.6)},
                 Attachment{1, Vec3::Zero(), Mat3::Identity()}};
  // The link's direction: turned about y by q0, then about z by q1, both steadily but for what the law says of q0.
  const double q0 = 0.4;
  const double q1 = std::asin(1.0) - away;
  const double u0 = 0.7;
  const double u1 = -2.0;
  const double udot0 = 3.0;
  const Mat3 C = joint.sides[0].C;
  const Mat3 Ry = rotation_about(Axis::y, q0);
  const Vec3 link = Ry * rotation_about(Axis::z, q1) * Vec3(0.5, 0.0, 0.0);
  const Vec3 w0 = u0 * Vec3::UnitY();
  const Vec3 w1 = u1 * (Ry * Vec3::UnitZ());
  const Vec3 w = w0 + w1;
  const Vec3 wdot = udot0 * Vec3::UnitY() + w0.cross(w1);
  State state;
  state.t = TwoHinges::kTime;
  state.bodies.resize(2);
  Evaluation evaluation;
  evaluation.bodies.resize(2);
  evaluation.joints.resize(1);
  for (int body = 0; body < 2; ++body) {
    state.bodies[body].a = state.bodies[body].adot = evaluation.bodies[body].addot = VecX(0);
  }
  BodyState& tip = state.bodies[1];
  tip.r = joint.sides[0].point_L + C * (link + off * Vec3(0.6, 0.0, 0.8));
  tip.v = C * w.cross(link);
  evaluation.bodies[1].vdot = C * (wdot.cross(link) + w.cross(w.cross(link)));
  state.q = {VecX::Zero(joint.type->n_q())};
  state.u = {VecX::Zero(joint.type->n_u())};
  const double t = state.t;
  const double law_udot = udot0 + udot_off;
  joint.drivers = {{0, Polynomial{{q0 - u0 * t + 0.5 * law_udot * t * t, u0 - law_udot * t, 0.5 * law_udot}}}};
  MotionAudit audit(model);
  audit.add(state, evaluation);
  AuditFinding worst;
  const AuditScales none{};
  for (const AuditEntity& entity : audit.joints()) keep_worse(worst, entity.worst(AuditRule::driver_law, none, none));
  return worst;
}

TEST(MotionAudit, AReadingThatMagnifiesHowAStateIsClosedIsNoBreach) {
  const AuditFinding plain = finding_near_a_gimbal_pose(0.8, 0.0, 0.0);
  EXPECT_GT(plain.digits, 10.0) << plain.text();
  const AuditFinding near = finding_near_a_gimbal_pose(1e-3, 1e-13, 0.0);
  EXPECT_TRUE(near.holds()) << near.text();
  const AuditFinding wrong = finding_near_a_gimbal_pose(1e-3, 0.0, 2.0);
  EXPECT_FALSE(wrong.holds()) << wrong.text();
  EXPECT_FALSE(finding_near_a_gimbal_pose(0.8, 0.0, 1e-4).holds());
}

TEST(MotionAudit, CoupledCoordinatesKeepTheirRelation) {
  const auto coupled = [](double offset, double u, double udot) {
    TwoHinges bench;
    bench.hinge(1, 2, -7.1, u, udot);
    bench.model.couplings = {{"belt", {{0, 0, 0, 2.0}, {1, 0, 0, -0.5}}, offset, {}}};
    return bench;
  };
  const double offset = 2.0 * 0.8 + 0.5 * 7.1;
  const AuditFinding right = coupled(offset, 8.4, -18.0).finding(AuditRule::driver_law);
  EXPECT_GT(right.digits, 11.0) << right.text();
  EXPECT_EQ(right.where, "belt");
  const AuditRule rule = AuditRule::driver_law;
  expect_row(coupled(offset + 1e-4, 8.4, -18.0), rule, "belt", "sum of coordinates");
  expect_row(coupled(offset, 8.4 + 1e-4, -18.0), rule, "belt", "sum of speeds");
  expect_row(coupled(offset, 8.4, -18.0 + 1e-2), rule, "belt", "sum of accelerations");
}

TEST(MotionAudit, AMachineAtRestIsHeldAgainstItsWeight) {
  TwoHinges bench;
  bench.hinge(0, 1, 0.8, 0.0, 0.0);
  bench.hinge(1, 2, -7.1, 0.0, 0.0);
  bench.evaluation.bodies[2].vdot = Vec3(1e-15, -2e-15, 1e-15);
  bench.state.bodies[1].omega = Vec3(0.0, 1e-15, 1e-15);
  EXPECT_GT(bench.finding(AuditRule::kinematics).digits, 13.0);
}

TEST(MotionAudit, ABalancedRotorWithoutWeightHasAScale) {
  TwoHinges bench;
  bench.model.gravity.setZero();
  for (Joint& joint : bench.model.joints) {
    for (Attachment& side : joint.sides) side.point_L.setZero();
  }
  bench.hinge(0, 1, 0.8, 40.0, -4.5);
  bench.hinge(1, 2, -7.1, -16.0, 3.2);
  bench.state.bodies[2].v.y() += 5e-17;
  bench.evaluation.bodies[2].vdot.z() -= 5e-16;
  const AuditFinding found = bench.finding(AuditRule::kinematics);
  EXPECT_TRUE(found.holds()) << found.text();
  bench.state.bodies[2].v.y() += 1e-7;
  EXPECT_FALSE(bench.finding(AuditRule::kinematics).holds());
}

TEST(MotionAudit, ABearingAtRestIsHeldAgainstTheRotorInIt) {
  TwoHinges bench;
  bench.model.gravity.setZero();
  bench.hinge(0, 1, 0.8, 0.0, 0.0);
  bench.hinge(1, 2, -7.1, -160.0, 3.2);
  bench.state.bodies[1].v.y() += 5e-15;
  bench.state.bodies[2].v.y() += 5e-15;
  const AuditFinding found = bench.finding(AuditRule::kinematics);
  EXPECT_TRUE(found.holds()) << found.text();
  bench.state.bodies[1].v.y() += 1e-9;
  bench.state.bodies[2].v.y() += 1e-9;
  EXPECT_FALSE(bench.finding(AuditRule::kinematics).holds());
}

TEST(MotionAudit, FarFromTheOriginItResolvesAsMuch) {
  TwoHinges bench;
  for (int body = 1; body < 3; ++body) bench.state.bodies[body].v += Vec3(3e4, 1e4, -2e4);
  bench.model.joints[0].type = joints::find("free");
  EXPECT_GT(bench.finding(AuditRule::kinematics).digits, 11.0);
}

}  // namespace
}  // namespace concord::compare
