#include "cartesian/solver.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cartesian/bodies/euler_parameters.h"
#include "common/joints/catalogue.h"
#include "common/reading/model_file.h"
#include "linkage.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

using ::testing::HasSubstr;

/// One rigid body on a tilted hinge to ground, off every axis.
Model make_pendulum() {
  testing::Numbers numbers(121);
  Model model;
  model.name = "pendulum";
  model.file = "pendulum.toml";
  model.gravity = {1.0, -9.0, 2.0};
  model.bodies.resize(1);
  model.bodies[kGround].name = "ground";
  model.bodies.push_back(testing::make_body(numbers, "bob", 0));
  model.joints.push_back(testing::make_joint(numbers, model, *joints::find("revolute"), kGround, 1));
  WordStart& start = model.joints[0].start[0];
  start.role_q = start.role_u = StartRole::keep;
  start.q(0) = 0.8;
  start.u(0) = 2.5;
  return model;
}

template <class Error, class Action>
std::string message_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(CartesianSolver, KeepsTheStartExactlyAndClosesToRoundOff) {
  const Model model = make_pendulum();
  const auto solver = make_solver(model);
  const State state = solver->assemble();
  EXPECT_NEAR(state.q[0](0), 0.8, 1e-15);
  EXPECT_NEAR(state.u[0](0), 2.5, 1e-14);
  EXPECT_NO_THROW((void)solver->evaluate(state));
}

/// Newton and Euler about the hinge point, by hand: accelerations from the reactions.
TEST(CartesianSolver, ReactionBalancesTheBodyAboutItsCentreOfMass) {
  const Model model = make_pendulum();
  const auto solver = make_solver(model);
  const State state = solver->assemble();
  const Evaluation evaluation = solver->evaluate(state);
  const Body& body = model.bodies[1];
  const BodyState& at = state.bodies[1];
  const Mat3 A = Eigen::Quaterniond(at.p(0), at.p(1), at.p(2), at.p(3)).toRotationMatrix();
  const Vec3 c = A * body.center_of_mass_L;
  const Vec3& alpha = evaluation.bodies[1].omegadot;
  const Vec3 acceleration = evaluation.bodies[1].vdot + alpha.cross(c) + at.omega.cross(at.omega.cross(c));
  const Wrench& wrench = evaluation.joints[0].total_on(Side::child).in_global;
  const Vec3 weight = body.mass * model.gravity;
  EXPECT_LT((body.mass * acceleration - weight - wrench.force).norm(), 1e-13 * weight.norm());
  const Mat3 inertia = A * body.inertia_L * A.transpose();
  const Vec3 lever = A * model.joints[0].on(Side::child).point_L - c;
  const Vec3 spin = inertia * alpha + at.omega.cross(inertia * at.omega);
  EXPECT_LT((spin - wrench.torque - lever.cross(wrench.force)).norm(), 1e-13 * weight.norm());
}

TEST(CartesianSolver, RefusesTooFewKeptCoordinates) {
  Model model = make_pendulum();
  model.joints[0].start[0].role_u = StartRole::guess;
  EXPECT_EQ(message_of<InputError>([&] { (void)make_solver(model)->assemble(); }),
            "pendulum.toml: error: the start keeps 1 joint coordinates and 0 joint speeds, but the machine has 1 "
            "independent ones (rigid ones, beside those that drivers move): keep exactly 1 of each, for example turn_z "
            "of joint "
            "'revolute'");
}

TEST(CartesianSolver, SaysWhatCannotBeKept) {
  const Model model = parse_model(R"(format = 1
[[body]]
name = "rod"
mass = 1.2
center_of_mass = [0.2, 0, 0]
inertia = [0.01, 0.02, 0.02]
[[joint]]
name = "near"
type = "spherical"
parent = "ground"
child = "rod"
[[joint]]
name = "far"
type = "spherical"
parent = { body = "ground", point = [0.4, 0, 0] }
child = { body = "rod", point = [0.4, 0, 0] }
)",
                                  "rod.toml");
  EXPECT_NE(message_of<InputError>([&] {
              (void)make_solver(model)->assemble();
            }).find("a rod between two balls turns freely about itself: let one of the two joints be universal"),
            std::string::npos);
}

TEST(CartesianSolver, NamesTheJointsOfAContradiction) {
  Model model = make_pendulum();
  model.joints.push_back(model.joints[0]);  // a second hinge elsewhere on the same body
  model.joints[1].name = "second";
  model.joints[1].sides[1].point_L += Vec3(0.0, 0.3, 3.0);
  const std::string message = message_of<InputError>([&] { (void)make_solver(model)->assemble(); });
  EXPECT_THAT(message, HasSubstr("the guesses do not lead to a pose that closes, whatever is kept"));
  EXPECT_THAT(message, HasSubstr("joint 'second' is left open by 3.015 m along ("));  // |(0, 0.3, 3)|
}

TEST(CartesianSolver, RefusesAStateThatIsNotClosed) {
  const Model model = make_pendulum();
  const auto solver = make_solver(model);
  State state = solver->assemble();
  state.bodies[1].r.x() += 1e-9;
  const std::string message = message_of<SolverError>([&] { (void)solver->evaluate(state); });
  EXPECT_THAT(message, HasSubstr("the state at t = 0 s is not closed: joint 'revolute' residual"));
}

TEST(CartesianSolver, RefusesAStateThatHoldsNoNumber) {
  const Model model = make_pendulum();
  const auto solver = make_solver(model);
  State state = solver->assemble();
  state.bodies[1].omega.y() = std::nan("");
  const std::string message = message_of<SolverError>([&] { (void)solver->evaluate(state); });
  EXPECT_EQ(message, "cartesian: the state at t = 0 s holds a number that is not finite");
}

TEST(CartesianSolver, RefusesAStateOfAnotherShape) {
  const Model model = make_pendulum();
  const auto solver = make_solver(model);
  const State state = solver->assemble();
  State few = state;
  few.bodies.pop_back();
  const char* expected = "cartesian: the state at t = 0 s has 1 bodies, ground among them, expected 2";
  EXPECT_EQ(message_of<SolverError>([&] { (void)solver->evaluate(few); }), expected);
  EXPECT_EQ(message_of<SolverError>([&] { (void)solver->rank(few); }), expected);
  EXPECT_EQ(message_of<SolverError>([&] { (void)solver->close(few); }), expected);
  State without_q = state;
  without_q.q[0].resize(0);
  EXPECT_THAT(message_of<SolverError>([&] { (void)solver->tangent(without_q); }),
              HasSubstr("has 0 coordinates of joint 'revolute', expected 1"));
}

/// A hinge whose axes are opposed obeys all of its rows.
TEST(CartesianSolver, RefusesAStateOnAnotherBranch) {
  const Model model = make_pendulum();
  const auto solver = make_solver(model);
  State state = solver->assemble();
  BodyState& bob = state.bodies[1];
  const Attachment& hinge = model.joints[0].on(Side::child);
  const Mat3 A = rotation_of(bob.p);
  const Vec3 point = bob.r + A * hinge.point_L;
  const Vec3 across = A * hinge.C.col(0);
  const Mat3 turned = rotation_about(across, EIGEN_PI) * A;
  const Eigen::Quaterniond orientation(turned);
  bob.p << orientation.w(), orientation.vec();
  bob.r = point - turned * hinge.point_L;
  bob.v.setZero();
  bob.omega.setZero();
  state.u[0].setZero();
  EXPECT_THAT(message_of<SolverError>([&] { (void)solver->evaluate(state); }),
              HasSubstr("joint 'revolute' stands on another branch than its type means"));
  RunOptions options;
  options.until = 0.01;
  options.start = state;
  EXPECT_THROW((void)solver->integrate(options, [](double) {}), SolverError);
}

/// Beyond a right angle the elevation of a rod reads from other signs: what a state says must not hang on the last one.
TEST(CartesianSolver, WhatAStateSaysDoesNotDependOnTheStateBefore) {
  const auto rod_at = [](double elevation) {
    return parse_model(fmt::format(R"(format = 1
[[body]]
name = "load"
mass = 1
inertia = [1, 2, 2.5]
[[joint]]
name = "rod"
type = "distance"
length = 0.7
parent = "ground"
child = {{ body = "load", point = [0.1, 0.2, 0.3] }}
start.turn_x = {{ keep = 0.5, keep_speed = 0.2 }}
start.turn_y = {{ guess = {}, guess_speed = 0 }}
start.ball = {{ keep = {{ axis = [0, 0, 1], angle = 0.3 }}, keep_speed = [0, 0, 0.1] }}
[[coupling]]
name = "ratio"
terms = [{{ joint = "rod", coordinate = "turn_x", factor = 1 }}, {{ joint = "rod", coordinate = "turn_y", factor = 2 }}]
offset = {}
)",
                                   elevation, 0.5 + 2.0 * elevation),
                       "rod.toml");
  };
  const Model far = rod_at(2.1);
  const auto fresh = make_solver(far);
  const State beyond = fresh->assemble();
  const MatX expected = make_solver(far)->tangent(beyond);
  State before = beyond;
  before.q[0](1) = 0.3;
  (void)fresh->rank(before);
  EXPECT_LT((fresh->tangent(beyond) - expected).norm(), 1e-12);
}

TEST(CartesianSolver, ClosesAShakenStateAndLeavesItsTurnsAlone) {
  const Model model = make_pendulum();
  const auto solver = make_solver(model);
  State state = solver->assemble();
  state.q[0](0) += 4.0 * EIGEN_PI;
  state.bodies[1].r += Vec3(0.01, -0.02, 0.03);
  state.bodies[1].omega += Vec3(0.1, 0.2, -0.1);
  const std::optional<State> closed = solver->close(state);
  ASSERT_TRUE(closed);
  EXPECT_NO_THROW((void)solver->evaluate(*closed));
  EXPECT_NEAR(closed->q[0](0), 0.8 + 4.0 * EIGEN_PI, 0.2);
}

/// Energy of the swing over 2 s and the same end state by both integrators.
TEST(CartesianSolver, IntegratorsAgreeAndKeepTheConstraints) {
  const Model model = make_pendulum();
  RunOptions options;
  options.until = 2.0;
  options.samples = 20;
  options.rtol = 1e-10;
  std::vector<double> ends;
  for (const std::string& integrator : make_solver(model)->integrators()) {
    options.integrator = integrator;
    const Trajectory trajectory = make_solver(model)->integrate(options, {});
    ASSERT_EQ(trajectory.samples.size(), 21u);
    EXPECT_LT(trajectory.statistics.max_constraint, 1e-13);
    ends.push_back(trajectory.samples.back().state.q[0](0));
  }
  ASSERT_EQ(ends.size(), 2u);
  EXPECT_NEAR(ends[0], ends[1], 1e-8);
}

/// A stiff strut to ground and a spring and motor on the hinge: the stiff integrator's matrix must know them.
TEST(CartesianSolver, IntegratorsAgreeOnStiffSprings) {
  Model model = make_pendulum();
  ForceLaw strut;
  strut.stiffness = 2e7;
  strut.damping = 1e5;
  strut.free = 1.5;
  testing::Numbers numbers(122);
  const Attachment on_ground = testing::make_attachment(numbers, model, kGround);
  model.elements.push_back({"strut", LineSpring{{on_ground, testing::make_attachment(numbers, model, 1)}, strut}, {}});
  ForceLaw hinge;
  hinge.stiffness = 20.0;
  hinge.actuator = Harmonic{1.0, 5.0, 7.0, 0.2};
  model.joints[0].springs.push_back({0, hinge});
  RunOptions options;
  options.until = 0.5;
  options.samples = 5;
  options.rtol = 1e-8;
  std::vector<double> ends;
  std::vector<long> steps;
  for (const char* integrator : {"gauss", "ida"}) {
    options.integrator = integrator;
    const Trajectory trajectory = make_solver(model)->integrate(options, {});
    ends.push_back(trajectory.samples.back().state.q[0](0));
    steps.push_back(trajectory.statistics.evaluations);
  }
  EXPECT_NEAR(ends[0], ends[1], 1e-7);
  EXPECT_LT(steps[1], steps[0] / 2) << steps[1];
}

TEST(CartesianSolver, FindsAKeptOrientationFromAFarGuess) {
  testing::Numbers numbers(123);
  Model model = make_pendulum();
  model.joints[0] = testing::make_joint(numbers, model, *joints::find("spherical"), kGround, 1);
  WordStart& start = model.joints[0].start[0];
  start.role_q = start.role_u = StartRole::keep;
  const Eigen::Quaterniond kept(Eigen::AngleAxisd(1.75, Vec3(2.0, 1.0, 1.0).normalized()));
  start.q << kept.w(), kept.x(), kept.y(), kept.z();
  const Mat3 wanted = model.joints[0].on(Side::parent).C * kept * model.joints[0].on(Side::child).C.transpose();
  const Mat3 away = rotation_about(Vec3(1.0, -2.0, 0.5).normalized(), -2.6);
  model.bodies[1].pose_guess = Pose{Vec3(0.2, -0.1, 0.3), away * wanted};
  const State state = make_solver(model)->assemble();
  EXPECT_LE((state.q[0] - start.q).norm(), 1e-14);
}

/// Without gravity and with the rigid part at rest nothing but the mode tells how fast things go.
TEST(CartesianSolver, RunsAMachineThatOnlyVibrates) {
  testing::Numbers numbers(124);
  Model model = make_pendulum();
  model.gravity.setZero();
  model.bodies[1] = testing::make_body(numbers, "bell", 1);
  model.joints[0] = testing::make_joint(numbers, model, *joints::find("weld"), kGround, 1);
  model.bodies[1].a_start << 0.01;
  RunOptions options;
  options.until = 1.0;
  options.samples = 10;
  options.rtol = 1e-9;
  const Trajectory trajectory = make_solver(model)->integrate(options, {});
  EXPECT_LT(trajectory.statistics.evaluations, 20000);
  double largest = 0.0;
  for (const Sample& sample : trajectory.samples) largest = std::max(largest, std::abs(sample.state.bodies[1].a(0)));
  EXPECT_GT(largest, 0.005);
}

TEST(CartesianSolver, EndsARunAfterTheStepInWhichNobodyWantsItAnyMore) {
  const Model model = make_pendulum();
  for (const std::string integrator : {"gauss", "ida"}) {
    RunOptions options;
    options.until = 40.0;
    options.samples = 1;
    options.rtol = 1e-9;
    options.integrator = integrator;
    double reached = 0.0;
    const auto stop = [&](double t) {
      reached = t;
      throw std::string("enough");
    };
    EXPECT_THROW((void)make_solver(model)->integrate(options, stop), std::string);
    EXPECT_GT(reached, 0.0) << integrator;
    EXPECT_LT(reached, 4.0) << integrator;
  }
}

TEST(CartesianSolver, TangentHoldsWhatTheJointPermits) {
  Model model = make_pendulum();
  testing::Numbers numbers(125);
  model.elements.push_back(
      {"push", Load{testing::make_attachment(numbers, model, 1)}, {}});  // a second place: a length
  ASSERT_NE(model.length_scale(), 1.0);
  const auto solver = make_solver(model);
  State state = solver->assemble();
  const MatX tangent = solver->tangent(state);
  ASSERT_EQ(tangent.cols(), 1);
  EXPECT_NEAR(tangent.norm(), 1.0, 1e-14);
  state.bodies[1].v = 3.0 * model.length_scale() * tangent.col(0).head<3>();
  state.bodies[1].omega = 3.0 * tangent.col(0).segment<3>(3);
  EXPECT_NO_THROW((void)solver->evaluate(state));
  state.bodies[1].v *= 1.001;
  EXPECT_THROW((void)solver->evaluate(state), SolverError);
}

TEST(CartesianSolver, NamesItsIntegratorsWhenAskedForAnother) {
  const Model model = make_pendulum();
  RunOptions options;
  options.integrator = "euler";
  EXPECT_EQ(message_of<InputError>([&] { (void)make_solver(model)->integrate(options, {}); }),
            "pendulum.toml: error: cartesian: unknown integrator 'euler'; it has gauss, ida");
}

/// A driver that has counted many turns holds its body to the last digits of what is left beside them.
TEST(CartesianSolver, DriversKeepTheirDigitsAfterManyTurns) {
  testing::Linkage linkage;
  linkage.crank = 0.2;
  linkage.last_crank = 0.5;
  linkage.angle = 5000.3;
  const Model model = linkage.make();
  const auto solver = make_solver(model);
  const State start = solver->assemble();
  const Vec4& p = start.bodies[1].p;
  const Mat3 A = Eigen::Quaterniond(p(0), p(1), p(2), p(3)).toRotationMatrix();
  EXPECT_LT((A - rotation_about(Axis::z, linkage.angle)).norm(), 2e-15);
  RunOptions options;
  options.until = 0.5;
  options.samples = 4;
  options.rtol = 1e-9;
  for (const Sample& sample : solver->integrate(options, {}).samples) {
    const Vec4& turned = sample.state.bodies[1].p;
    const Mat3 now = Eigen::Quaterniond(turned(0), turned(1), turned(2), turned(3)).toRotationMatrix();
    EXPECT_LT((now - rotation_about(Axis::z, linkage.angle + linkage.rate * sample.state.t)).norm(), 4e-15);
  }
}

}  // namespace
}  // namespace concord::cartesian
