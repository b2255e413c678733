#include "relative/closure/speed_constraints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "machines.h"
#include "relative/solver.h"

namespace concord::relative {
namespace {

/// The spatial slider-crank with a cylindrical joint D, two degrees of freedom, and a coupling of the crank with the
/// turn and the slide of D: one.
Model coupled_loop(bool flexible) {
  Model model = test::spatial_slider_crank(flexible);
  test::Numbers numbers(77);
  model.joints[3] = test::fitting_joint(model, "D", "cylindrical", 3, 0, Vec3(0.61, 0.11, 0.13), numbers);
  model.joints[3].where = {"slider_crank.toml", 40, 1};
  test::add_springs(model.joints[3]);
  model.couplings = {{"G", {{0, 0, 0, 1.4}, {3, 1, 0, -0.8}, {3, 0, 0, 2.3}}, 0.0, {"slider_crank.toml", 50, 1}}};
  const auto q = [&](int joint, int word) { return model.joints[joint].start[word].q(0); };
  model.couplings[0].offset = 1.4 * q(0, 0) - 0.8 * q(3, 1) + 2.3 * q(3, 0);
  return model;
}

/// What a coupling adds up to in a state.
double sum_of(const Coupling& coupling, const std::vector<VecX>& values) {
  double sum = 0.0;
  for (const CouplingTerm& term : coupling.terms) {
    sum += term.factor * values[term.joint](term.word + term.component);  // no balls: words are coordinates
  }
  return sum;
}

class CoupledLoop : public ::testing::TestWithParam<std::tuple<int, bool>> {};

TEST_P(CoupledLoop, IsTheSameWhereverItIsCut) {
  const auto [cut, driven] = GetParam();
  Model model = coupled_loop(true);
  model.couplings[0].offset -= 0.06;  // Newton's method has work to do
  if (driven) {
    // The crank is coupled and driven; nothing else is free.
    test::release(model.joints[0]);
    model.joints[0].drivers = {{0, Polynomial{{model.joints[0].start[0].q(0), 1.2, 0.7}}, 0}};
  }
  const State state = make_solver(model)->assemble();
  EXPECT_NEAR(sum_of(model.couplings[0], state.q), model.couplings[0].offset, 1e-14);
  EXPECT_NEAR(sum_of(model.couplings[0], state.u), 0.0, 1e-13);
  const Evaluation reference = make_solver(model)->evaluate(state);
  for (int k = 0; k < 4; ++k) model.joints[k].named_as_cut = k == cut;
  const std::unique_ptr<Solver> solver = make_solver(model);
  const Evaluation evaluation = solver->evaluate(state);
  ASSERT_EQ(evaluation.couplings.size(), 1u);
  EXPECT_GT(std::abs(evaluation.couplings[0]), 0.1);
  EXPECT_NEAR(evaluation.couplings[0], reference.couplings[0], 1e-10);
  for (int i = 1; i < 4; ++i) {
    EXPECT_LT((evaluation.bodies[i].vdot - reference.bodies[i].vdot).norm(), 1e-10);
    EXPECT_LT((evaluation.bodies[i].omegadot - reference.bodies[i].omegadot).norm(), 1e-10);
  }
  const test::Imbalance left_over = test::imbalance(model, state, evaluation);
  EXPECT_LT(left_over.force + left_over.torque + left_over.modal, 1e-10);
  for (int k = 0; k < 4; ++k) {
    const JointWrenches& joint = evaluation.joints[k];
    for (const Side side : {Side::parent, Side::child}) {
      const auto differ = [&](const SideWrench& one, const SideWrench& other) {
        return (one.in_C.vector() - other.in_C.vector()).norm();
      };
      EXPECT_LT(differ(joint.reaction_on(side), reference.joints[k].reaction_on(side)), 1e-9) << k;
      EXPECT_LT(differ(joint.total_on(side), reference.joints[k].total_on(side)), 1e-9) << k;
    }
    EXPECT_LT((joint.tau - reference.joints[k].tau).norm(), 1e-9) << k;
  }
  // The reaction does no work on D, and its total pushes with springs and coupling: tau = spring + factor f.
  const Joint& D = model.joints[3];
  const Wrench& reaction = evaluation.joints[3].reaction_on(Side::child).in_C;
  EXPECT_NEAR(reaction.force.z(), 0.0, 1e-10);
  EXPECT_NEAR(reaction.torque.z(), 0.0, 1e-10);
  for (int c = 0; c < 2; ++c) {
    const ForceLaw& law = D.springs[c].law;
    const double spring = evaluate_actuator(law, 0.0) - evaluate_resistance(law, state.q[3](c), state.u[3](c)).force;
    const double factor = c == 0 ? 2.3 : -0.8;
    EXPECT_NEAR(evaluation.joints[3].tau(c), spring + factor * evaluation.couplings[0], 1e-9);
  }
  if (!driven) {
    EXPECT_NEAR(evaluation.joints[0].tau(0), 1.4 * evaluation.couplings[0], 1e-10);
  }
  const RankReport report = solver->rank(state);
  EXPECT_EQ(report.constraints, driven ? 18 : 17);
  EXPECT_EQ(report.rank, report.constraints);
  EXPECT_EQ(report.degrees_of_freedom, 3 + (driven ? 0 : 1));
}

INSTANTIATE_TEST_SUITE_P(CutAtEach, CoupledLoop, ::testing::Combine(::testing::Range(0, 4), ::testing::Bool()));

class CoupledRun : public ::testing::TestWithParam<std::tuple<const char*, bool>> {};

TEST_P(CoupledRun, KeepsItsRelationAndItsEnergy) {
  const auto [integrator, driven] = GetParam();
  Model model = coupled_loop(false);
  if (driven) {
    test::release(model.joints[0]);
    model.joints[0].drivers = {{0, Polynomial{{model.joints[0].start[0].q(0), 1.2, 0.7}}, 0}};
  }
  RunOptions options;
  options.until = 0.2;
  options.rtol = 1e-10;
  options.samples = 4;
  options.integrator = integrator;
  for (const int cut : {0, 3}) {
    for (int k = 0; k < 4; ++k) model.joints[k].named_as_cut = k == cut;
    const Trajectory run = make_solver(model)->integrate(options, {});
    const double at_start = test::energy(model, run.samples.front().state);
    for (const Sample& sample : run.samples) {
      EXPECT_NEAR(sum_of(model.couplings[0], sample.state.q), model.couplings[0].offset, 1e-13);
      EXPECT_NEAR(sum_of(model.couplings[0], sample.state.u), 0.0, 1e-12);
      EXPECT_NEAR(test::energy(model, sample.state) - sample.work, at_start, 1e-8) << sample.state.t;
    }
    EXPECT_LT(run.statistics.max_constraint, 1e-13);
  }
}

INSTANTIATE_TEST_SUITE_P(Integrators, CoupledRun,
                         ::testing::Combine(::testing::Values("adams", "dirk"), ::testing::Bool()));

/// Discs on hinges, axis x or z of a carrier that turns about z of its own hinge: everything at generic places along
/// the axes, frames tilted as one.
struct Carrier {
  Model model;
  Mat3 plane;

  explicit Carrier(double inertia) : plane(rotation_about(Vec3(Vec3(1, -2, 0.5).normalized()), 0.9)) {
    model.file = "gears.toml";
    Body body;
    body.name = "carrier";
    body.mass = 2.0;
    body.inertia_L = Vec3(inertia, 1.3 * inertia, inertia).asDiagonal();
    model.bodies = {test::ground(), body};
    add_hinge("carrier", 0, 1, {Vec3(0.3, 0.1, -0.2), plane}, {Vec3::Zero(), Mat3::Identity()}, 0.4, 0.9);
  }

  void add_hinge(const std::string& name, int parent, int child, const Pose& on_parent, const Pose& on_child, double q,
                 double u) {
    Joint joint;
    joint.name = name;
    joint.type = joints::find("revolute");
    joint.sides = {Attachment{parent, on_parent.r, on_parent.A}, Attachment{child, on_child.r, on_child.A}};
    joint.start = {{StartRole::keep, StartRole::keep, VecX::Constant(1, q), VecX::Constant(1, u)}};
    model.joints.push_back(joint);
  }

  /// A disc of spin inertia `spin` whose axis is z of its frame, on the carrier at a pose.
  void add_disc(const std::string& name, double mass, double spin, const Pose& at, double q, double u) {
    Body disc;
    disc.name = name;
    disc.mass = mass;
    disc.inertia_L = Vec3(0.6 * spin, 0.6 * spin, spin).asDiagonal();
    model.bodies.push_back(disc);
    add_hinge(name, 1, static_cast<int>(model.bodies.size()) - 1, at, {Vec3::Zero(), Mat3::Identity()}, q, u);
  }

  void apply_wrench(int joint, double torque) {
    ForceLaw law;
    law.actuator = Polynomial{{torque}};
    model.joints[joint].springs = {{0, law, 0}};
  }
};

/// Two gears of teeth n on a carrier: (I_0 + I_1 + I_2) W' + I_1 u_1' + I_2 u_2' = T_0, I_k (W' + u_k') = T_k + n_k f,
/// n_1 u_1' + n_2 u_2' = 0.
TEST(SpeedConstraints, GearsOnATurningCarrierObeyNewtonAndEuler) {
  const double n_1 = 17.0;
  const double n_2 = 29.0;
  const double I_1 = 0.012;
  const double I_2 = 0.047;
  const Vec3 d_1(0.21, -0.08, 0.05);
  const Vec3 d_2(-0.17, 0.13, 0.02);
  Carrier gears(0.3);
  gears.add_disc("first", 0.7, I_1, {d_1, Mat3::Identity()}, 0.3, 1.7);
  gears.add_disc("second", 1.1, I_2, {d_2, Mat3::Identity()}, 40.0, 0.0);
  Model& model = gears.model;
  // Some turns away, so that the second wheel must be wound, and is then a little off.
  model.couplings = {{"G", {{1, 0, 0, n_1}, {2, 0, 0, n_2}}, 0.8, {}}};
  test::release(model.joints[2]);
  gears.apply_wrench(0, 1.9);
  gears.apply_wrench(1, -0.6);
  for (const bool cut : {false, true}) {
    if (cut) {
      // The second gear flies freely beside its hinge: the coupled joint is cut.
      model.joints[2].named_as_cut = true;
      test::Numbers numbers(2);
      model.joints.push_back(test::joint(model, "flight", "free", 3, 0, numbers));
      test::release(model.joints.back());
    }
    const std::unique_ptr<Solver> solver = make_solver(model);
    const State state = solver->assemble();
    EXPECT_NEAR(n_1 * state.q[1](0) + n_2 * state.q[2](0), 0.8, 1e-12);
    EXPECT_LT(std::abs(state.q[2](0)), 4.0);
    const Evaluation evaluation = solver->evaluate(state);
    const double I_0 = 0.3 + 0.7 * d_1.head<2>().squaredNorm() + 1.1 * d_2.head<2>().squaredNorm();
    Eigen::Matrix4d A;  // of W', u_1', u_2', f
    A << I_0 + I_1 + I_2, I_1, I_2, 0, I_1, I_1, 0, -n_1, I_2, 0, I_2, -n_2, 0, n_1, n_2, 0;
    const Eigen::Vector4d x = A.fullPivLu().solve(Eigen::Vector4d(1.9, -0.6, 0.0, 0.0));
    EXPECT_NEAR((gears.plane.transpose() * evaluation.bodies[1].omegadot).z(), x(0), 1e-11);
    EXPECT_NEAR((gears.plane.transpose() * evaluation.bodies[2].omegadot).z(), x(0) + x(1), 1e-11);
    EXPECT_NEAR((gears.plane.transpose() * evaluation.bodies[3].omegadot).z(), x(0) + x(2), 1e-11);
    EXPECT_NEAR(evaluation.couplings[0], x(3), 1e-12);
    EXPECT_NEAR(evaluation.joints[1].tau(0), -0.6 + n_1 * x(3), 1e-12);
    EXPECT_NEAR(evaluation.joints[2].tau(0), n_2 * x(3), 1e-12);
    EXPECT_NEAR(evaluation.joints[2].total_on(Side::child).in_C.torque.z(), n_2 * x(3), 1e-12);
    EXPECT_NEAR(evaluation.joints[2].reaction_on(Side::child).in_C.torque.z(), 0.0, 1e-12);
    // The bearing carries the wheel round: m (W' x d + W x (W x d)).
    const double W = state.u[0](0);
    const Vec3 held = 1.1 * (x(0) * Vec3::UnitZ().cross(d_2) - W * W * Vec3(d_2.x(), d_2.y(), 0.0));
    const Vec3 found =
        rotation_about(Axis::z, state.q[2](0)) * evaluation.joints[2].reaction_on(Side::child).in_C.force;
    EXPECT_LT((found - held).norm(), 1e-11);
  }
}

/// Half shafts and the cage of a differential in a car that yaws: q_l + q_r - 2 q_c = 0. About the axle
/// I_k u_k' = T_k + n_k f; the yaw alone turns the shafts' spins, torque I_k u_k W about the vertical.
TEST(SpeedConstraints, DifferentialInAYawingCarObeysNewtonAndEuler) {
  const Vec3 I(0.011, 0.019, 0.043);
  const Vec3 n(1.0, 1.0, -2.0);
  const Vec3 T(-0.4, -0.9, 2.2);
  const Vec3 u(3.1, 7.7, 5.4);
  Carrier car(0.8);
  const Mat3 axle = rotation_about(Axis::y, std::numbers::pi / 2.0);  // z of the hinges along x of the car
  const std::array<const char*, 3> names{"left", "right", "cage"};
  for (int k = 0; k < 3; ++k) {
    car.add_disc(names[k], 0.5, I(k), {Vec3(0.3 * (k - 1), 0.0, 0.1), axle}, 0.2 + 0.3 * k, u(k));
    car.apply_wrench(k + 1, T(k));
  }
  car.model.couplings = {{"differential", {{1, 0, 0, n(0)}, {2, 0, 0, n(1)}, {3, 0, 0, n(2)}}, 0.0, {}}};
  test::release(car.model.joints[3]);
  const std::unique_ptr<Solver> solver = make_solver(car.model);
  const State state = solver->assemble();
  EXPECT_NEAR(state.q[3](0), 0.5 * (state.q[1](0) + state.q[2](0)), 1e-14);
  EXPECT_NEAR(state.u[3](0), 5.4, 1e-14);
  const Evaluation evaluation = solver->evaluate(state);
  const double f = -(n.array() * T.array() / I.array()).sum() / (n.array().square() / I.array()).sum();
  EXPECT_NEAR(evaluation.couplings[0], f, 1e-12);
  const double W = state.u[0](0);
  for (int k = 0; k < 3; ++k) {
    const Vec3 omegadot = (car.plane * rotation_about(Axis::z, 0.4)).transpose() * evaluation.bodies[2 + k].omegadot;
    EXPECT_NEAR(omegadot.x(), (T(k) + n(k) * f) / I(k), 1e-10) << k;
    EXPECT_NEAR(omegadot.y(), W * u(k), 1e-11) << k;
    const JointWrenches& hinge = evaluation.joints[1 + k];
    EXPECT_NEAR(hinge.tau(0), T(k) + n(k) * f, 1e-12);
    // In the axes of the car: the gyroscopic torque stands across axle and yaw.
    const Vec3 torque = axle * hinge.reaction_on(Side::parent).in_C.torque;
    EXPECT_NEAR(torque.y(), -I(k) * u(k) * W, 1e-12) << k;
    EXPECT_NEAR(torque.x(), 0.0, 1e-12) << k;
  }
}

/// Two couplings that say the same: one row too many, found and left unjudged nowhere, for a coupling's force is no
/// reaction.
TEST(SpeedConstraints, CountsADependentCouplingAsRedundant) {
  Model model = coupled_loop(false);
  model.couplings.push_back(model.couplings[0]);
  model.couplings[1].name = "H";
  for (CouplingTerm& term : model.couplings[1].terms) term.factor *= -3.0;
  model.couplings[1].offset *= -3.0;
  const std::unique_ptr<Solver> solver = make_solver(model);
  const State state = solver->assemble();
  const RankReport report = solver->rank(state);
  EXPECT_EQ(report.constraints, 18);
  EXPECT_EQ(report.rank, 17);
  EXPECT_EQ(report.degrees_of_freedom, 1);
  for (const JointUniqueness& joint : report.joints) {
    for (const auto& side : joint.unique) EXPECT_TRUE(std::all_of(side.begin(), side.end(), [](bool u) { return u; }));
  }
  EXPECT_NO_THROW((void)solver->evaluate(state));
}

std::string closing_complaint(const Model& model) {
  try {
    (void)make_solver(model)->assemble();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no complaint";
}

TEST(SpeedConstraints, RefuseKeptValuesThatContradictThem) {
  Model model = coupled_loop(false);
  for (WordStart& word : model.joints[3].start) word.role_q = word.role_u = StartRole::keep;
  model.joints[3].start[0].q(0) += 0.01;
  EXPECT_THAT(closing_complaint(model),
              testing::HasSubstr("the values contradict each other: with turn_z of joint 'A' as kept, slide_z of joint "
                                 "'D' is 0.39849848, where 0.40849848 is kept to 1e-09; the speed of slide_z of "));
}

TEST(SpeedConstraints, NameTheCouplingThatAStateBreaks) {
  const Model model = coupled_loop(false);
  Model free = model;
  free.couplings.clear();
  for (WordStart& word : free.joints[3].start) word.role_q = word.role_u = StartRole::guess;
  free.joints[3].start[1].role_q = free.joints[3].start[1].role_u = StartRole::keep;
  free.joints[3].start[1].q(0) += 0.3;
  const State state = make_solver(free)->assemble();
  try {
    (void)make_solver(model)->evaluate(state);
    FAIL() << "a state that breaks the coupling was accepted";
  } catch (const SolverError& error) {
    EXPECT_NE(std::string(error.what()).find("at coupling 'G', allowed 1e-12: close it first"), std::string::npos)
        << error.what();
  }
  const std::optional<State> closed = make_solver(model)->close(state);
  ASSERT_TRUE(closed.has_value());
  EXPECT_NO_THROW((void)make_solver(model)->evaluate(*closed));
}

}  // namespace
}  // namespace concord::relative
