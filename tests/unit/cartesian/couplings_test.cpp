#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cartesian/solver.h"
#include "common/error.h"
#include "common/joints/catalogue.h"
#include "machines.h"

/// Couplings of joint coordinates, from the start to the reactions, through the solver.
namespace concord::cartesian {
namespace {

using ::testing::HasSubstr;
using testing::Numbers;

void keep(Joint& joint, int word, double q, double u) {
  WordStart& start = joint.start[word];
  start.role_q = start.role_u = StartRole::keep;
  start.q(0) = q;
  start.u(0) = u;
}

enum Parts { kCarrierHinge, kWheelHinge, kCross, kRackSlide };

/// A carrier that turns on ground; on it a wheel, a body on a universal joint and a rack. A differential relates three
/// turns, the carrier's own among them; the wheel drives the rack.
Model make_differential() {
  Numbers numbers(211);
  Model model;
  model.name = "differential";
  model.file = "differential.toml";
  model.gravity = {1.0, -9.0, 2.0};
  model.bodies.resize(1);
  model.bodies[kGround].name = "ground";
  for (const char* name : {"carrier", "wheel", "satellite", "rack"}) {
    model.bodies.push_back(testing::make_body(numbers, name, 0));
  }
  const auto join = [&](const char* type, int parent, int child) {
    model.joints.push_back(testing::make_joint(numbers, model, *joints::find(type), parent, child));
    model.joints.back().name = model.bodies[child].name;
  };
  join("revolute", kGround, 1);
  join("revolute", 1, 2);
  join("universal", 1, 3);
  join("translational", 1, 4);
  keep(model.joints[kWheelHinge], 0, 0.7, 3.0);
  keep(model.joints[kCross], 0, -0.4, 1.5);
  keep(model.joints[kCross], 1, 0.5, -2.0);
  model.couplings.push_back(
      {"G", {{kCarrierHinge, 0, 0, -2.0}, {kWheelHinge, 0, 0, 1.0}, {kCross, 0, 0, 1.2}}, 0.3, {}});
  model.couplings.push_back({"H", {{kRackSlide, 0, 0, 1.0}, {kWheelHinge, 0, 0, 0.05}}, 0.1, {}});
  return model;
}

Mat3 rotation_of_body(const State& state, int body) {
  const Vec4& p = state.bodies[body].p;
  return Eigen::Quaterniond(p(0), p(1), p(2), p(3)).toRotationMatrix();
}

/// Wrenches on a body's centre of mass less what its accelerations need.
Vec6 imbalance(const Model& model, const State& state, const Evaluation& evaluation, int i) {
  const Body& body = model.bodies[i];
  const Mat3 A = rotation_of_body(state, i);
  const Vec3 c = A * body.center_of_mass_L;
  const Vec3& omega = state.bodies[i].omega;
  const Vec3& alpha = evaluation.bodies[i].omegadot;
  const Mat3 inertia = A * body.inertia_L * A.transpose();
  Vec3 force = body.mass * (model.gravity - evaluation.bodies[i].vdot - alpha.cross(c) - omega.cross(omega.cross(c)));
  Vec3 torque = -(inertia * alpha + omega.cross(inertia * omega));
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Side side : {Side::parent, Side::child}) {
      if (model.joints[k].on(side).body != i) continue;
      const Wrench& wrench = evaluation.joints[k].total_on(side).in_global;
      force += wrench.force;
      torque += wrench.torque + (A * model.joints[k].on(side).point_L - c).cross(wrench.force);
    }
  }
  Vec6 both;
  both << force, torque;
  return both;
}

double relation(const Coupling& coupling, const std::vector<VecX>& values) {
  double sum = 0.0;
  for (const CouplingTerm& term : coupling.terms) sum += term.factor * values[term.joint](term.word + term.component);
  return sum;
}

TEST(Couplings, TakeFreedomAtTheStartAndHoldWithTheTurnsCounted) {
  Model model = make_differential();
  model.joints[kWheelHinge].start[0].q(0) = 250.0;  // the carrier follows, 20 times round
  const State state = make_solver(model)->assemble();
  EXPECT_NEAR(state.q[kWheelHinge](0), 250.0, 1e-12);
  EXPECT_NEAR(relation(model.couplings[0], state.q), 0.3, 1e-12);
  EXPECT_NEAR(relation(model.couplings[1], state.q), 0.1, 1e-12);
  EXPECT_NEAR(relation(model.couplings[0], state.u), 0.0, 1e-12);
  EXPECT_NEAR(relation(model.couplings[1], state.u), 0.0, 1e-12);
  EXPECT_NEAR(state.q[kCarrierHinge](0), (250.0 - 1.2 * 0.4 - 0.3) / 2.0, 1e-12);
  EXPECT_NO_THROW((void)make_solver(model)->evaluate(state));
}

/// Newton and Euler for every body with the wrenches as reported, reactions without part in the coordinates, forces of
/// the couplings in each coordinate, and accelerations that obey the relations: together they leave no freedom.
TEST(Couplings, ForcesAndReactionsBalanceEveryBody) {
  const Model model = make_differential();
  const auto solver = make_solver(model);
  const State state = solver->assemble();
  const Evaluation evaluation = solver->evaluate(state);
  for (int i = 1; i <= 4; ++i) EXPECT_LT(imbalance(model, state, evaluation, i).norm(), 1e-12) << "body " << i;

  ASSERT_EQ(evaluation.couplings.size(), 2u);
  const double G = evaluation.couplings[0];
  const double H = evaluation.couplings[1];
  EXPECT_GT(std::abs(G), 0.1);
  EXPECT_GT(std::abs(H), 0.1);
  const auto tau = [&](int k, int c) { return evaluation.joints[k].tau(c); };
  EXPECT_NEAR(tau(kCarrierHinge, 0), -2.0 * G, 1e-12 * std::abs(G));
  EXPECT_NEAR(tau(kWheelHinge, 0), G + 0.05 * H, 1e-12 * (std::abs(G) + std::abs(H)));
  EXPECT_NEAR(tau(kCross, 0), 1.2 * G, 1e-12 * std::abs(G));
  EXPECT_EQ(tau(kCross, 1), 0.0);
  EXPECT_NEAR(tau(kRackSlide, 0), H, 1e-12 * std::abs(H));

  for (const int k : {kCarrierHinge, kWheelHinge}) {
    EXPECT_NEAR(evaluation.joints[k].reaction_on(Side::child).in_C.torque.z(), 0.0, 1e-12);
    EXPECT_NEAR(evaluation.joints[k].reaction_on(Side::parent).in_C.torque.z(), 0.0, 1e-12);
    EXPECT_NEAR(evaluation.joints[k].total_on(Side::child).in_C.torque.z(), tau(k, 0), 1e-12);
  }
  const Joint& cross = model.joints[kCross];
  const Vec3 x_parent = rotation_of_body(state, 1) * cross.on(Side::parent).C.col(0);
  const Vec3 y_child = rotation_of_body(state, 3) * cross.on(Side::child).C.col(1);
  const JointWrenches& at_cross = evaluation.joints[kCross];
  EXPECT_NEAR(at_cross.reaction_on(Side::child).in_global.torque.dot(x_parent), 0.0, 1e-12);
  EXPECT_NEAR(at_cross.reaction_on(Side::child).in_global.torque.dot(y_child), 0.0, 1e-12);
  EXPECT_NEAR(at_cross.total_on(Side::child).in_global.torque.dot(x_parent), tau(kCross, 0), 1e-12);
  EXPECT_NEAR(at_cross.total_on(Side::child).in_global.torque.dot(y_child), 0.0, 1e-12);
}

/// Without power: kinetic energy and that of gravity keep their sum.
TEST(Couplings, HoldThroughARunAndKeepTheEnergy) {
  const Model model = make_differential();
  for (const char* integrator : {"gauss", "ida"}) {
    SCOPED_TRACE(integrator);
    RunOptions options;
    options.until = 3.0;
    options.samples = 30;
    options.rtol = 1e-9;
    options.integrator = integrator;
    const auto solver = make_solver(model);
    const Trajectory trajectory = solver->integrate(options, {});
    double most_turned = 0.0;
    for (const Sample& sample : trajectory.samples) {
      EXPECT_NEAR(relation(model.couplings[0], sample.state.q), 0.3, 1e-12);
      EXPECT_NEAR(relation(model.couplings[1], sample.state.q), 0.1, 1e-12);
      EXPECT_NO_THROW((void)solver->evaluate(sample.state));
      most_turned = std::max(most_turned, std::abs(sample.state.q[kWheelHinge](0)));
      EXPECT_EQ(sample.work, 0.0);
    }
    EXPECT_GT(most_turned, 4.0);
    EXPECT_LT(trajectory.statistics.max_constraint, 1e-12);
    const auto energy = [&](const State& state) {
      double sum = 0.0;
      for (int i = 1; i <= 4; ++i) {
        const Body& body = model.bodies[i];
        const Mat3 A = rotation_of_body(state, i);
        const Vec3 c = A * body.center_of_mass_L;
        const Vec3 omega_L = A.transpose() * state.bodies[i].omega;
        sum += 0.5 * body.mass * (state.bodies[i].v + state.bodies[i].omega.cross(c)).squaredNorm() +
               0.5 * omega_L.dot(body.inertia_L * omega_L) - body.mass * model.gravity.dot(state.bodies[i].r + c);
      }
      return sum;
    };
    EXPECT_NEAR(energy(trajectory.samples.back().state), energy(trajectory.samples.front().state), 1e-6);
  }
}

/// Balanced wheels on a carrier driven at a constant rate: I_1 q1" = M + f, I_2 q2" = k f, q1 + k q2 = 0.
TEST(Couplings, GearPairOnATurningCarrierAgainstItsClosedForm) {
  Numbers numbers(213);
  Model model;
  model.name = "gears";
  model.file = "gears.toml";
  model.bodies.resize(1);
  const Vec3 inertia_1(0.2, 0.2, 0.35);
  const Vec3 inertia_2(0.4, 0.4, 0.05);
  for (const Vec3& inertia : {Vec3(1.0, 2.0, 2.5), inertia_1, inertia_2}) {
    Body body;
    body.mass = 2.0;
    body.inertia_L = inertia.asDiagonal();
    model.bodies.push_back(body);
  }
  const Mat3 tilt = numbers.rotation();
  const auto join = [&](int parent, int child, const Vec3& at) {
    Joint joint = testing::make_joint(numbers, model, *joints::find("revolute"), parent, child);
    joint.sides[0] = {parent, at, parent == kGround ? tilt : Mat3(Mat3::Identity()), Mat3X(3, 0), Mat3X(3, 0)};
    joint.sides[1] = {child, Vec3::Zero(), Mat3::Identity(), Mat3X(3, 0), Mat3X(3, 0)};
    model.joints.push_back(joint);
  };
  join(kGround, 1, Vec3(0.1, 0.2, 0.3));
  join(1, 2, Vec3(0.5, 0.0, 0.0));
  join(1, 3, Vec3(-0.2, 0.1, 0.4));
  constexpr double kRate = 3.0;
  constexpr double kRatio = 2.5;
  constexpr double kMotor = 4.0;
  model.joints[0].drivers = {{0, ConstantSpeed{0.0, kRate}, 0}};
  keep(model.joints[1], 0, 0.0, 1.0);
  ForceLaw motor;
  motor.actuator = ConstantSpeed{kMotor, 0.0};
  model.joints[1].springs.push_back({0, motor});
  model.couplings.push_back({"G", {{1, 0, 0, 1.0}, {2, 0, 0, kRatio}}, 0.0, {}});
  const auto solver = make_solver(model);
  const State state = solver->assemble();
  const Evaluation evaluation = solver->evaluate(state);
  const double acceleration = kMotor / (inertia_1.z() + inertia_2.z() / (kRatio * kRatio));
  EXPECT_NEAR(evaluation.bodies[2].omegadot.dot(tilt.col(2)), acceleration, 1e-12 * acceleration);
  EXPECT_NEAR(evaluation.bodies[3].omegadot.dot(tilt.col(2)), -acceleration / kRatio, 1e-12 * acceleration);
  EXPECT_NEAR(evaluation.couplings[0], inertia_1.z() * acceleration - kMotor, 1e-12 * kMotor);
  const double driver = inertia_1.z() * acceleration - inertia_2.z() * acceleration / kRatio;
  EXPECT_NEAR(evaluation.joints[0].tau(0), driver, 1e-11 * kMotor);
}

TEST(Couplings, ARedundantOneIsFoundAndLeavesReactionsUnique) {
  Model model = make_differential();
  const Evaluation once = make_solver(model)->evaluate(make_solver(model)->assemble());
  model.couplings.push_back(model.couplings[0]);
  model.couplings[2].name = "again";
  for (CouplingTerm& term : model.couplings[2].terms) term.factor *= 3.0;
  model.couplings[2].offset *= 3.0;
  const auto solver = make_solver(model);
  const State state = solver->assemble();
  const RankReport report = solver->rank(state);
  EXPECT_EQ(report.constraints, 5 + 5 + 4 + 5 + 3);
  EXPECT_EQ(report.rank, report.constraints - 1);
  EXPECT_EQ(report.degrees_of_freedom, 3);
  EXPECT_EQ(report.unique_coupling, (std::vector<bool>{false, true, false}));
  EXPECT_EQ(report.decided_coupling, (std::vector<bool>{true, true, true}));
  const Evaluation twice = solver->evaluate(state);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Side side : {Side::parent, Side::child}) {
      for (const bool unique : report.joints[k].unique[index(side)]) EXPECT_TRUE(unique);
      EXPECT_LT(
          (twice.joints[k].reaction_on(side).in_C.vector() - once.joints[k].reaction_on(side).in_C.vector()).norm(),
          1e-10);
    }
  }
  EXPECT_EQ(solver->tangent(state).cols(), 3);
}

TEST(Couplings, ContradictingStartIsRefusedByName) {
  Model model = make_differential();
  keep(model.joints[kCarrierHinge], 0, 1.0, 0.0);
  std::string message;
  try {
    (void)make_solver(model)->assemble();
  } catch (const InputError& error) {
    message = error.what();
  }
  EXPECT_THAT(message, HasSubstr("the values contradict each other: with turn_z of joint 'carrier', turn_z of joint "
                                 "'wheel', turn_y of joint 'satellite' as kept, turn_x of joint 'satellite' is "
                                 "1.33333333, where -0.4 is kept to 1e-09; "));
}

TEST(Couplings, AStateOffTheRelationIsRefusedByName) {
  const Model model = make_differential();
  const auto solver = make_solver(model);
  State state = solver->assemble();
  state.q[kCross](0) += 2.0 * EIGEN_PI;
  std::string message;
  try {
    (void)solver->evaluate(state);
  } catch (const SolverError& error) {
    message = error.what();
  }
  EXPECT_THAT(message, HasSubstr("the state at t = 0 s is not closed: coupling 'G' residual"));
}

/// Whole turns of a coupling's coordinates cancel and leave its digits alone: the wheel makes twice as many as the
/// carrier.
TEST(Couplings, StandAlikeAfterManyTurns) {
  constexpr double kTurns = 6000.0;
  constexpr long double kWholeTurn = 6.283185307179586476925286766559L;
  Model often = make_differential();
  often.couplings.pop_back();  // the rack would go along
  keep(often.joints[kRackSlide], 0, 0.1, -0.2);
  Model once = often;
  // The double that counts them stands for an angle some units of its last place beside.
  double& angle = often.joints[kWheelHinge].start[0].q(0);
  angle = static_cast<double>(0.7L + kWholeTurn * kTurns);
  once.joints[kWheelHinge].start[0].q(0) = static_cast<double>(angle - kWholeTurn * kTurns);
  const auto solver = make_solver(often);
  const State then = solver->assemble();
  const State first = make_solver(once)->assemble();
  EXPECT_NEAR(then.q[kCarrierHinge](0) - first.q[kCarrierHinge](0), EIGEN_PI * kTurns, 1e-10);
  for (int body = 1; body < static_cast<int>(first.bodies.size()); ++body) {
    EXPECT_LT((rotation_of_body(then, body) - rotation_of_body(first, body)).norm(), 1e-14) << body;
  }
  EXPECT_NO_THROW((void)solver->evaluate(then));
}

}  // namespace
}  // namespace concord::cartesian
