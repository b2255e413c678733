#include "relative/bodies/joint_point.h"

#include <gtest/gtest.h>

#include "machines.h"
#include "relative/bodies/exponential_map.h"

namespace concord::relative {
namespace {

/// A flexible body in general motion along an exact path: constant rates of r', of the rotation vector and of a, to be
/// differentiated by central differences.
class JointPointOnMovingBody : public ::testing::Test {
 protected:
  JointPointOnMovingBody() : numbers_(4) {
    model_.bodies = {test::ground(), test::flexible_body("bar", 3, numbers_)};
    joint_ = test::joint(model_, "P", "weld", 0, 1, numbers_);
    a_ = numbers_.vector(3, 0.3);
    adot_ = numbers_.vector(3, 0.9);
    addot_ = numbers_.vector(3, 1.4);
    r_ = numbers_.vector(1.0);
    v_ = numbers_.vector(1.0);
    vdot_ = numbers_.vector(1.0);
    theta_ = numbers_.vector(0.8);
    thetadot_ = numbers_.vector(1.0);
  }

  /// The body at time t and the joint point on it.
  JointPoint at(double t, BodyMotion& body) const {
    const Vec3 theta = theta_ + t * thetadot_;
    const ExponentialMap map = exponential_map(theta);
    body.r = r_ + t * v_ + 0.5 * t * t * vdot_;
    body.v = v_ + t * vdot_;
    body.A = map.R;
    body.omega = map.J * thetadot_;
    const VecX a = a_ + t * adot_ + 0.5 * t * t * addot_;
    const VecX adot = adot_ + t * addot_;
    JointPoint point("joint 'P'", joint_.on(Side::child));
    point.deform(a.data(), adot.data());
    point.compute_point_motion(body);
    return point;
  }

  test::Numbers numbers_;
  Model model_;
  Joint joint_;
  VecX a_, adot_, addot_;
  Vec3 r_, v_, vdot_, theta_, thetadot_;
};

TEST_F(JointPointOnMovingBody, VelocityIsTheDerivativeOfPlaceAndFrame) {
  const double h = 1e-5;
  BodyMotion body;
  const JointPoint ahead = at(h, body);
  const JointPoint behind = at(-h, body);
  const JointPoint here = at(0.0, body);
  EXPECT_LT((here.v - (ahead.r - behind.r) / (2 * h)).norm(), 1e-9);
  EXPECT_LT((here.omega - rotation_vector(ahead.A * behind.A.transpose()) / (2 * h)).norm(), 1e-9);
}

TEST_F(JointPointOnMovingBody, AccelerationIsLinearInThatOfTheBodyPlusBias) {
  const double h = 1e-5;
  BodyMotion ahead_body;
  BodyMotion behind_body;
  BodyMotion body;
  const JointPoint ahead = at(h, ahead_body);
  const JointPoint behind = at(-h, behind_body);
  const JointPoint here = at(0.0, body);
  const Vec3 omegadot = (ahead_body.omega - behind_body.omega) / (2 * h);
  Vec6 expected;
  expected << (ahead.v - behind.v) / (2 * h), (ahead.omega - behind.omega) / (2 * h);
  Vec6 found = here.bias + here.Ga() * addot_;
  found.head<3>() += vdot_ + omegadot.cross(here.lever);
  found.tail<3>() += omegadot;
  EXPECT_LT((found - expected).norm(), 1e-8);
}

TEST_F(JointPointOnMovingBody, SettleInvertsRide) {
  BodyMotion body;
  const JointPoint ridden = at(0.0, body);
  JointPoint settled = ridden;
  BodyMotion found;
  settled.compute_body_motion(found);
  EXPECT_LT((found.r - body.r).norm(), 1e-15);
  EXPECT_LT((found.A - body.A).norm(), 1e-15);
  EXPECT_LT((found.v - body.v).norm(), 1e-15);
  EXPECT_LT((found.omega - body.omega).norm(), 1e-15);
  EXPECT_LT((settled.bias - ridden.bias).norm(), 1e-14);
  EXPECT_LT((settled.Ga() - ridden.Ga()).norm(), 1e-15);
}

TEST_F(JointPointOnMovingBody, RefusesAFrameTurnedByHalfATurn) {
  JointPoint point("joint 'P'", joint_.on(Side::child));
  const VecX far = 10.0 * VecX::Ones(3);
  try {
    point.deform(far.data(), adot_.data());
    FAIL() << "a rotation vector longer than pi was accepted";
  } catch (const SolverError& error) {
    EXPECT_NE(std::string(error.what()).find("joint 'P': deformation has turned its frame by"), std::string::npos);
  }
}

}  // namespace
}  // namespace concord::relative
