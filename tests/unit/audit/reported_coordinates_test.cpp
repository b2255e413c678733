#include "compare/audit/reported_coordinates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "common/joints/cylindrical.h"
#include "common/joints/spherical.h"
#include "common/rotation.h"
#include "compare/audit/referee.h"

namespace concord::compare {
namespace {

using testing::HasSubstr;

/// An arm on a ball and a sleeve on a guide, both on ground, their frames at the origins of their bodies; a coil
/// between sleeve and guide.
Model machine() {
  Model model;
  model.bodies.resize(3);
  model.joints.resize(2);
  model.joints[0].name = "shoulder";
  model.joints[0].type = &joints::spherical;
  model.joints[1].name = "guide";
  model.joints[1].type = &joints::cylindrical;
  for (int k = 0; k < 2; ++k) {
    model.bodies[k + 1].name = model.joints[k].name;
    model.bodies[k + 1].mass = 1.0;
    model.joints[k].sides[0].body = 0;
    model.joints[k].sides[1].body = k + 1;
  }
  model.elements.push_back({"coil", TurnSpring{model.joints[1].sides, {}}, {}});
  model.run.until = 0.3;
  return model;
}

/// The bodies where these coordinates and speeds put them.
State state_at(const Model& model, double t, const std::vector<VecX>& q, const std::vector<VecX>& u) {
  State state;
  state.t = t;
  state.bodies.resize(model.bodies.size());
  state.q = q;
  state.u = u;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const RefereedMotion motion = referee_motion(*model.joints[k].type, q[k]);
    const Vec6 v_rel = motion.S.leftCols(u[k].size()) * u[k];
    BodyState& body = state.bodies[k + 1];
    const Eigen::Quaterniond turned(motion.placement.R);
    body.r = motion.placement.d;
    body.p << turned.w(), turned.vec();
    body.v = v_rel.head<3>();
    body.omega = v_rel.tail<3>();
  }
  return state;
}

/// The audit of a motion that reports what `spoil` leaves of its coordinates and speeds after 0.1 s.
ReportedCoordinate audit(const std::function<void(State&)>& spoil) {
  const Model model = machine();
  Trajectory run;
  for (int k = 0; k <= 20; ++k) {
    const double t = 0.015 * k;
    const Eigen::Quaterniond ball(Eigen::AngleAxisd(0.5 + 2.0 * t, Vec3(1.0, 0.3, -0.4).normalized()));
    const Vec4 p(ball.w(), ball.x(), ball.y(), ball.z());
    const VecX guide = Eigen::Vector2d(0.1 + 0.4 * t, 3.5 - 3.0 * t);
    Sample& sample = run.samples.emplace_back();
    sample.state = state_at(model, t, {VecX(p), guide}, {VecX(Vec3(0.5, -1.2, 2.0)), VecX(Eigen::Vector2d(0.4, -3.0))});
    sample.state.spring_angles = {guide(1)};
    if (t > 0.1) spoil(sample.state);
  }
  return audit_reported_coordinates(model, run);
}

std::string text_of(const std::function<void(State&)>& spoil) {
  const ReportedCoordinate found = audit(spoil);
  EXPECT_FALSE(found.holds());
  return found.text();
}

}  // namespace

TEST(ReportedCoordinates, AreThoseOfTheBodies) {
  const ReportedCoordinate found = audit([](State&) {});
  EXPECT_TRUE(found.holds()) << found.text();
  EXPECT_GT(found.digits, 13.0) << found.text();
}

TEST(ReportedCoordinates, OfAnotherMotionAreNamed) {
  EXPECT_THAT(text_of([](State& s) { s.q[1](0) *= 1.001; }), HasSubstr("joint 'guide', slide_z, t = "));
  EXPECT_THAT(text_of([](State& s) { s.q[1](1) += 1e-6; }), HasSubstr("joint 'guide', turn_z, t = "));
  EXPECT_THAT(text_of([](State& s) { s.u[1](0) = -s.u[1](0); }), HasSubstr("joint 'guide', speed of slide_z, t = "));
  EXPECT_THAT(text_of([](State& s) { s.u[0].reverseInPlace(); }), HasSubstr("joint 'shoulder', speed of ball, t = "));
  EXPECT_THAT(text_of([](State& s) { s.q[0].tail<3>() *= -1.0; }), HasSubstr("joint 'shoulder', ball, t = "));
  EXPECT_THAT(text_of([](State& s) { s.q[0] *= 1.001; }), HasSubstr("joint 'shoulder', ball, t = "));
  EXPECT_THAT(text_of([](State& s) { s.spring_angles[0] += 1e-6; }), HasSubstr("force element 'coil', angle, t = "));
}

TEST(ReportedCoordinates, MayHaveWholeTurnsAndEitherSignOfEulerParameters) {
  EXPECT_TRUE(audit([](State& s) { s.q[0] = -s.q[0]; }).holds());
  EXPECT_TRUE(audit([](State& s) { s.q[1](1) += 4.0 * EIGEN_PI; }).holds());
  EXPECT_TRUE(audit([](State& s) { s.spring_angles[0] -= 4.0 * EIGEN_PI; }).holds());
}

}  // namespace concord::compare
