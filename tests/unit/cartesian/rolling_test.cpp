#include <gtest/gtest.h>

#include <cmath>

#include "cartesian/dynamics/equations.h"
#include "cartesian/rank/constraint_rank.h"
#include "cartesian/solver.h"
#include "common/joints/catalogue.h"
#include "machines.h"

/// Constraints of velocity alone, against closed forms of nonholonomic mechanics.
namespace concord::cartesian {
namespace {

using testing::kGravity;
using testing::Numbers;
using testing::rigid;

Model make_ground(const char* name) {
  Model model;
  model.name = name;
  model.file = std::string(name) + ".toml";
  model.bodies.resize(1);
  model.bodies[kGround].name = "ground";
  return model;
}

void keep_q(WordStart& start, const VecX& q) {
  start.role_q = StartRole::keep;
  start.q = q;
}
void keep_u(WordStart& start, const VecX& u) {
  start.role_u = StartRole::keep;
  start.u = u;
}
VecX one(double value) { return VecX::Constant(1, value); }

constexpr double kMass = 3.0;
constexpr double kSpin = 0.4;     // about the centre of mass
constexpr double kAhead = 0.3;    // centre of mass before the edge
constexpr double kAngle = 0.6;    // of the edge at the start
constexpr double kSpeed = 1.3;    // along the edge
constexpr double kTurning = 2.1;  // rad/s

/// Chaplygin's sleigh: a knife edge on a tilted plane without gravity.
Model make_sleigh(const Mat3& tilt) {
  Numbers numbers(221);
  Model model = make_ground("sleigh");
  Body body;
  body.name = "sleigh";
  body.mass = kMass;
  const Mat3 turned = numbers.rotation();
  const Vec3 point = numbers.vector();
  body.center_of_mass_L = point + turned * Vec3(kAhead, 0.0, 0.2);
  body.inertia_L = turned * Vec3(0.3, 0.5, kSpin).asDiagonal() * turned.transpose();
  model.bodies.push_back(body);
  Joint joint = testing::make_joint(numbers, model, *joints::find("knife_edge"), kGround, 1);
  joint.sides = {rigid(kGround, Vec3(0.4, -0.2, 0.1), tilt), rigid(1, point, turned)};
  keep_q(joint.start[0], one(0.2));
  keep_q(joint.start[1], one(-0.7));
  keep_q(joint.start[2], one(kAngle));
  keep_u(joint.start[0], one(kSpeed * std::cos(kAngle)));
  keep_u(joint.start[2], one(kTurning));
  model.joints.push_back(joint);
  return model;
}

/// v' = a omega^2, (I + m a^2) omega' = -m a v omega; the edge presses sideways with m (v omega + a omega').
TEST(Rolling, ChaplyginsSleigh) {
  const Mat3 tilt = Numbers(222).rotation();
  const Model model = make_sleigh(tilt);
  const auto solver = make_solver(model);
  const State state = solver->assemble();
  EXPECT_NEAR(state.u[0](1), kSpeed * std::sin(kAngle), 1e-13);
  const RankReport rank = solver->rank(state);
  EXPECT_EQ(rank.constraints, 4);
  EXPECT_EQ(rank.degrees_of_freedom, 2);
  EXPECT_EQ(solver->tangent(state).cols(), 2);

  const Evaluation evaluation = solver->evaluate(state);
  const double turning_rate = -kMass * kAhead * kSpeed * kTurning / (kSpin + kMass * kAhead * kAhead);
  EXPECT_NEAR(evaluation.bodies[1].omegadot.dot(tilt.col(2)), turning_rate, 1e-12);
  const Wrench& on_child = evaluation.joints[0].reaction_on(Side::child).in_C;
  EXPECT_NEAR(on_child.force.y(), kMass * (kSpeed * kTurning + kAhead * turning_rate), 1e-12);
  EXPECT_NEAR(on_child.force.x(), 0.0, 1e-12);
  const Wrench& in_global = evaluation.joints[0].reaction_on(Side::child).in_global;
  const Wrench& on_parent = evaluation.joints[0].reaction_on(Side::parent).in_global;
  const Vec3 gap = tilt * Vec3(state.q[0](0), state.q[0](1), 0.0);  // the parent's joint point stays behind
  EXPECT_LT((on_parent.force + in_global.force).norm(), 1e-13);
  EXPECT_LT((on_parent.torque + in_global.torque + gap.cross(in_global.force)).norm(), 1e-13);

  for (const char* integrator : {"gauss", "ida"}) {
    SCOPED_TRACE(integrator);
    RunOptions options;
    options.until = 4.0;
    options.samples = 20;
    options.rtol = 1e-10;
    options.integrator = integrator;
    const Trajectory trajectory = solver->integrate(options, {});
    EXPECT_LT(trajectory.statistics.max_constraint, 1e-13);
    // v^2 + (I / m + a^2) omega^2 is kept, and omega follows 1 / cosh.
    const double c = std::sqrt(kSpin / kMass + kAhead * kAhead);
    const double size = std::hypot(kSpeed, c * kTurning);
    const double phase = std::atanh(kSpeed / size);
    const State& end = trajectory.samples.back().state;
    const double x = phase + kAhead * size / (c * c) * options.until;
    EXPECT_NEAR(end.u[0](2), size / c / std::cosh(x), 1e-7);
    const double v = end.u[0](0) * std::cos(end.q[0](2)) + end.u[0](1) * std::sin(end.q[0](2));
    EXPECT_NEAR(v, size * std::tanh(x), 1e-7);
  }
}

/// A homogeneous ball on a plane, frames of ball and plane turned.
struct BallRig {
  static constexpr double kRadius = 0.35;
  static constexpr double kBallMass = 2.0;

  Model model;

  BallRig(Model on, int parent, const Attachment& plane) : model(std::move(on)) {
    Numbers numbers(223);
    Body ball;
    ball.name = "ball";
    ball.mass = kBallMass;
    ball.inertia_L = 0.4 * kBallMass * kRadius * kRadius * Mat3::Identity();
    model.bodies.push_back(ball);
    const int child = static_cast<int>(model.bodies.size()) - 1;
    const auto type = std::make_shared<joints::JointType>(joints::find("rolling_ball")->with_parameters({kRadius}));
    Joint joint = testing::make_joint(numbers, model, *type, parent, child);
    joint.own_type = type;
    joint.sides = {plane, rigid(child, Vec3::Zero(), numbers.rotation())};
    keep_q(joint.start[0], one(0.4));
    keep_q(joint.start[1], one(-0.3));
    keep_q(joint.start[2], Vec4(0.5, -0.1, 0.7, 0.5).normalized());
    keep_u(joint.start[2], Vec3(1.5, -0.8, 2.5));
    model.joints.push_back(joint);
  }
};

/// 5/7 of the slope's pull, whatever the spin; friction is 2/7 of it and acts a radius below the centre.
TEST(Rolling, BallOnASlope) {
  const Mat3 tilt = rotation_about(Vec3(1.0, -2.0, 0.3).normalized(), 0.5);
  Model ground = make_ground("slope");
  ground.gravity = {0.0, 0.0, -kGravity};
  const BallRig rig(std::move(ground), kGround, rigid(kGround, Vec3(0.3, 0.1, -0.4), tilt));
  const auto solver = make_solver(rig.model);
  const State state = solver->assemble();
  EXPECT_EQ(solver->rank(state).degrees_of_freedom, 3);
  EXPECT_NEAR(state.u[0](0), -0.8 * BallRig::kRadius, 1e-13);  // omega x (radius up)
  EXPECT_NEAR(state.u[0](1), -1.5 * BallRig::kRadius, 1e-13);
  const Evaluation evaluation = solver->evaluate(state);
  const Vec3 pull = tilt.transpose() * rig.model.gravity;
  const Vec3 along(pull.x(), pull.y(), 0.0);
  EXPECT_LT((tilt.transpose() * evaluation.bodies[1].vdot - 5.0 / 7.0 * along).norm(), 1e-12);
  const Wrench& wrench = evaluation.joints[0].reaction_on(Side::child).in_global;
  const Vec3 force = tilt.transpose() * wrench.force;
  const Vec3 wanted = BallRig::kBallMass * (-2.0 / 7.0 * along - Vec3(0.0, 0.0, pull.z()));
  EXPECT_LT((force - wanted).norm(), 1e-12);
  const Vec3 torque = tilt.transpose() * wrench.torque;
  EXPECT_LT((torque - Vec3(0.0, 0.0, -BallRig::kRadius).cross(Vec3(force.x(), force.y(), 0.0))).norm(), 1e-12);
}

/// On a turntable the centre runs on a circle at 2/7 of the table's rate.
TEST(Rolling, BallOnATurntable) {
  constexpr double kTableRate = 2.0;
  Numbers numbers(224);
  const Mat3 tilt = numbers.rotation();
  Model model = make_ground("turntable");
  model.gravity = -kGravity * tilt.col(2);
  model.bodies.push_back(testing::make_body(numbers, "table", 0));
  Joint axle = testing::make_joint(numbers, model, *joints::find("revolute"), kGround, 1);
  const Mat3 on_table = numbers.rotation();
  axle.sides = {rigid(kGround, Vec3(0.2, 0.1, 0.5), tilt), rigid(1, Vec3(0.1, -0.2, 0.3), on_table)};
  axle.drivers = {{0, ConstantSpeed{0.3, kTableRate}, 0}};
  model.joints.push_back(axle);
  const BallRig rig(std::move(model), 1, rigid(1, Vec3(0.1, -0.2, 0.3) + on_table * Vec3(0.2, 0.5, 0.7), on_table));
  const Vec3 rate = 2.0 / 7.0 * kTableRate * tilt.col(2);
  for (const char* integrator : {"gauss", "ida"}) {
    SCOPED_TRACE(integrator);
    const auto solver = make_solver(rig.model);
    RunOptions options;
    options.until = 2.0 * EIGEN_PI / rate.norm();  // once round
    options.samples = 16;
    options.rtol = 1e-10;
    options.integrator = integrator;
    const Trajectory trajectory = solver->integrate(options, {});
    const BodyState& first = trajectory.samples.front().state.bodies[2];
    EXPECT_GT(first.v.norm(), 0.2);
    for (const Sample& sample : trajectory.samples) {
      EXPECT_LT((sample.evaluation.bodies[2].vdot - rate.cross(sample.state.bodies[2].v)).norm(), 1e-11);
    }
    EXPECT_LT((trajectory.samples.back().state.bodies[2].r - first.r).norm(), 1e-6);
    EXPECT_LT(trajectory.statistics.max_constraint, 1e-12);
  }
}

/// Two edges on one axle forbid the same: all four rows of the second depend on those of the first.
TEST(Rolling, TwoEdgesOnAnAxleAreOneConstraintTooMany) {
  const Mat3 tilt = Numbers(225).rotation();
  Model model = make_sleigh(tilt);
  Joint second = model.joints[0];
  second.name = "second";
  second.sides[1].point_L += 0.8 * second.sides[1].C.col(1);
  for (WordStart& word : second.start) word.role_q = word.role_u = StartRole::guess;
  model.joints.push_back(second);
  const auto solver = make_solver(model);
  const State state = solver->assemble();
  const RankReport report = solver->rank(state);
  EXPECT_EQ(report.constraints, 8);
  EXPECT_EQ(report.rank, 4);
  EXPECT_FALSE(report.joints[0].unique[index(Side::child)][1]);
  RunOptions options;
  options.until = 1.0;
  options.samples = 4;
  options.rtol = 1e-9;
  for (const char* integrator : {"gauss", "ida"}) {
    options.integrator = integrator;
    EXPECT_LT(solver->integrate(options, {}).statistics.max_constraint, 1e-12);
  }
}

/// An edge that looks along a guide says nothing new, but the guide's rows hold places and must stay.
TEST(Rolling, ADependentRowOfVelocityGivesWayToThoseOfPlaces) {
  Model model = make_sleigh(Mat3::Identity());
  Numbers numbers(226);
  Joint guide = testing::make_joint(numbers, model, *joints::find("translational"), kGround, 1);
  Mat3 along_x;
  along_x << Vec3::UnitY(), Vec3::UnitZ(), Vec3::UnitX();
  const Mat3 edge = rotation_about(Axis::z, kAngle);
  guide.sides[0] = rigid(kGround, Vec3(0.4, -0.2, 0.1) + Vec3(0.2, -0.7, 0.0), edge * along_x);
  guide.sides[1] = rigid(1, model.joints[0].sides[1].point_L, model.joints[0].sides[1].C * along_x);
  keep_q(guide.start[0], one(0.0));
  keep_u(guide.start[0], one(1.0));
  for (WordStart& word : model.joints[0].start) word.role_q = word.role_u = StartRole::guess;
  model.joints.push_back(guide);
  const auto solver = make_solver(model);
  const State state = solver->assemble();
  Equations equations(model);
  VecX q(7);
  VecX Y(6);
  equations.layout().unpack(state, q, Y);
  equations.update(0.0, q, Y);
  const std::vector<bool> independent = choose_rows(equations).independent;
  EXPECT_EQ(std::count(independent.begin(), independent.end(), true), 5);
  EXPECT_FALSE(independent[3]);  // the edge's own
  RunOptions options;
  options.until = 1.0;
  options.samples = 4;
  EXPECT_NEAR(solver->integrate(options, {}).samples.back().state.q[1](0), 1.0, 1e-11);
}

}  // namespace
}  // namespace concord::cartesian
