#include <gmock/gmock.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/decompositions.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/kinematics.h"
#include "compare/analyses/report.h"
#include "compare/equilibrium/equilibrium.h"
#include "compare/equilibrium/rests.h"
#include "compare/states/chart.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare::analyses {
namespace {

using ::testing::HasSubstr;

/// Inertia about the hinge and moment of the weight about it at the angle q, by hand.
struct PendulumByHand {
  Model model = pendulum_model();
  Vec3 axis = model.joints[0].sides[0].C.col(2);

  [[nodiscard]] Vec3 arm(double q) const {
    const Mat3 A = model.joints[0].sides[0].C * rotation_about(Axis::z, q) * model.joints[0].sides[1].C.transpose();
    return A * (model.bodies[1].center_of_mass_L - model.joints[0].sides[1].point_L);
  }
  [[nodiscard]] double moment(double q) const { return axis.dot(arm(q).cross(model.bodies[1].mass * model.gravity)); }
  [[nodiscard]] double inertia() const {
    const Vec3 axis_L = model.joints[0].sides[1].C.col(2);
    const Body& bob = model.bodies[1];
    return axis_L.dot(bob.inertia_L * axis_L) + bob.mass * axis.cross(arm(0.0)).squaredNorm();
  }
};

class AnalysesTest : public ::testing::Test {
 protected:
  static SolverMakers makers() {
    return {[](const Model& model) { return std::make_unique<FakePendulum>(model, "cartesian"); },
            [](const Model& model) { return std::make_unique<FakePendulum>(model, "relative"); }};
  }

  Model model_ = pendulum_model();
};

TEST_F(AnalysesTest, APendulumHangsWhereItsWeightHasNoMoment) {
  const Model held = held_at_start(model_);
  EXPECT_EQ(held.joints[0].start[0].u(0), 0.0);
  FakePendulum solver(held, "cartesian");
  const Equilibrium found = find_equilibrium(held, solver);
  const PendulumByHand hand;
  const double q = found.state.q[0](0);
  EXPECT_NEAR(hand.moment(q), 0.0, 1e-13);
  EXPECT_LT((hand.moment(q + 1e-4) - hand.moment(q - 1e-4)), 0.0) << "it hangs and does not stand";
  EXPECT_EQ(found.unstable, 0);
  EXPECT_TRUE(found.free.empty());
}

TEST_F(AnalysesTest, FromNearlyUprightItFallsToHanging) {
  FakePendulum first(model_, "cartesian");
  const double hanging = find_equilibrium(held_at_start(model_), first).state.q[0](0);
  Model upright = held_at_start(model_);
  upright.joints[0].start[0].q(0) = hanging + std::acos(-1.0) - 1e-3;
  FakePendulum solver(upright, "cartesian");
  const Equilibrium found = find_equilibrium(upright, solver);
  EXPECT_NEAR(std::cos(found.state.q[0](0) - hanging), 1.0, 1e-13);
  EXPECT_EQ(found.unstable, 0);
}

TEST_F(AnalysesTest, ADirectionWithoutStiffnessIsNamedAndLeft) {
  model_.gravity = 9.81 * model_.joints[0].sides[0].C.col(2);  // along the hinge
  const Model held = held_at_start(model_);
  FakePendulum solver(held, "cartesian");
  const Equilibrium found = find_equilibrium(held, solver);
  ASSERT_EQ(found.free.size(), 1U);
  EXPECT_EQ(found.free[0].name, "turn_z of A");
  EXPECT_NEAR(found.state.q[0](0), 0.7, 1e-12);
}

TEST_F(AnalysesTest, AForceThatNothingMeetsIsRefused) {
  model_.gravity = 9.81 * model_.joints[0].sides[0].C.col(2);
  JointSpring motor;
  motor.law.actuator = ConstantSpeed{0.3, 0.0};
  model_.joints[0].springs = {motor};
  const Model held = held_at_start(model_);
  FakePendulum solver(held, "cartesian");
  try {
    find_equilibrium(held, solver);
    FAIL();
  } catch (const SolverError& error) {
    EXPECT_THAT(error.what(), HasSubstr("cartesian: statics: nothing resists turn_z of A: it is pushed and meets no "
                                        "stiffness"));
  }
}

TEST_F(AnalysesTest, APendulumSwingsAtTheRootOfStiffnessOverInertia) {
  const AnalysisVerdict result = judge_linearization(model_, makers(), true);
  EXPECT_EQ(result.wrenches.outcome, Outcome::agree) << format_analysis(model_, result, true);
  const Linearization& found = *result.linearizations[0];
  ASSERT_EQ(found.modes.size(), 1U);
  const PendulumByHand hand;
  const Vec3 across = model_.gravity - hand.axis * hand.axis.dot(model_.gravity);
  const Vec3 arm = hand.arm(0.0);
  const double stiffness = 1.7 * across.norm() * (arm - hand.axis * hand.axis.dot(arm)).norm();
  const double omega = std::sqrt(stiffness / hand.inertia());
  EXPECT_NEAR(found.modes[0].eigenvalue.imag() / omega, 1.0, 1e-12);
  EXPECT_EQ(found.modes[0].damping_ratio(), 0.0);
  EXPECT_EQ(found.modes[0].motion, "turn_z of A");
}

TEST_F(AnalysesTest, ADampedPendulumDecays) {
  JointSpring damper;
  damper.law.damping = 0.05;
  model_.joints[0].springs = {damper};
  const AnalysisVerdict result = judge_linearization(model_, makers(), true);
  const Mode& mode = result.linearizations[0]->modes.at(0);
  EXPECT_NEAR(mode.eigenvalue.real(), -0.5 * 0.05 / PendulumByHand().inertia(), 1e-10);
  EXPECT_NEAR(mode.damping_ratio(), -mode.eigenvalue.real() / std::abs(mode.eigenvalue), 1e-15);
}

TEST_F(AnalysesTest, StaticsSeesASolverThatPushesMore) {
  Model sprung = sprung_pendulum_model();
  EXPECT_EQ(judge_statics(sprung, makers()).wrenches.outcome, Outcome::agree);
  SolverMakers unlike = makers();
  unlike.relative = [kept = std::vector<std::shared_ptr<Model>>()](const Model& model) mutable {
    kept.push_back(std::make_shared<Model>(model));
    std::get<LineSpring>(kept.back()->elements[0].what).law.stiffness *= 1.0 + 1e-6;
    return std::make_unique<FakePendulum>(*kept.back(), "relative");
  };
  const AnalysisVerdict result = judge_statics(sprung, unlike);
  EXPECT_EQ(result.wrenches.outcome, Outcome::differ);
  EXPECT_THAT(format_analysis(sprung, result, false), HasSubstr("FAIL sprung: "));
}

TEST_F(AnalysesTest, RestsThatTheOtherSolverTakesForRestsTooAreNotDetermined) {
  model_.gravity = 9.81 * model_.joints[0].sides[0].C.col(2);  // along the hinge: it rests anywhere
  const Model held = held_at_start(model_);
  Model turned = held;
  turned.joints[0].start[0].q(0) = 0.9;
  const Solvers solvers{std::make_unique<FakePendulum>(held, "cartesian"),
                        std::make_unique<FakePendulum>(held, "relative")};
  Rests rests = find_rests(held, solvers);
  EXPECT_NO_THROW(refuse_undetermined_rest(held, solvers, rests));
  rests.found[1] = find_equilibrium(held, *solvers[1], FakePendulum(turned, "relative").assemble());
  rests.states[1] = one_sample(rests.found[1].state, rests.found[1].evaluation);
  try {
    refuse_undetermined_rest(held, solvers, rests);
    FAIL();
  } catch (const SolverError& error) {
    EXPECT_THAT(error.what(), HasSubstr("statics: the equilibrium is not determined: the solvers come to different "
                                        "rests, and each takes the other one's for a rest, too; where they part: "));
  }
}

TEST_F(AnalysesTest, KinematicsRefusesFreedomByItsNumber) {
  FakePendulum solver(model_, "cartesian");
  try {
    run_kinematics(model_, solver, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("pendulum.toml: error: kinematics needs a machine whose motion is fully driven, but 1 "
                          "degree of freedom is left"));
  }
}

TEST_F(AnalysesTest, InverseDrivesWhatIsKeptThroughItsStart) {
  const auto coordinates = prescribed_coordinates(model_, {{"A", "turn_z", 2.5}});
  ASSERT_EQ(coordinates.size(), 1U);
  EXPECT_EQ(coordinates[0].name(model_), "turn_z of A");
  FakePendulum solver(model_, "cartesian");
  const Model driven =
      driven_through(model_, solver.assemble(), coordinates, [](const Model& /*model*/) { return true; });
  EXPECT_EQ(std::get<Polynomial>(driven.joints[0].drivers.at(0).law).coefficients,
            (std::vector<double>{0.7, 3.1, 1.25}));
  EXPECT_EQ(driven.joints[0].start[0].role_q, StartRole::unsaid);
  Evaluation evaluation;
  evaluation.joints.resize(1);
  evaluation.joints[0].tau = VecX::Constant(1, -4.0);
  const Model actuated = actuated_by(sprung_pendulum_model(), evaluation, coordinates);
  ASSERT_EQ(actuated.joints[0].springs.size(), 1U) << "the spring that was there is in tau";
  EXPECT_EQ(evaluate_actuator(actuated.joints[0].springs[0].law, 7.0), -4.0);
  EXPECT_THROW(prescribed_coordinates(model_, {{"A", "slide_z", 1.0}}), InputError);
}

/// A pendulum that says of its start pose that it permits another number of motions than any other pose does.
class OddPendulum : public FakePendulum {
 public:
  OddPendulum(const Model& model, int at_start, int elsewhere)
      : FakePendulum(model, "cartesian"), start_(FakePendulum::assemble()), counts_{at_start, elsewhere} {}

  MatX tangent(const State& state) override {
    const bool is_start = (state.bodies[1].p - start_.bodies[1].p).norm() < 1e-14;
    const MatX swing = FakePendulum::tangent(state);
    MatX all = MatX::Identity(6, 3);
    all.col(0) = swing;
    all = orthonormal_columns(all);
    return all.leftCols(is_start ? counts_[0] : counts_[1]);
  }

 private:
  State start_;
  std::array<int, 2> counts_;
};

TEST_F(AnalysesTest, APoseWithMoreMotionsThanItsNeighboursIsRefusedAsSingular) {
  const Model held = held_at_start(model_);
  OddPendulum flat(held, 2, 1);
  Chart chart(held, flat, flat.assemble());
  ASSERT_EQ(chart.n(), 2);
  try {
    static_cast<void>(chart.at(VecX::Constant(2, 1e-3), VecX::Zero(2)));
    FAIL();
  } catch (const SingularPose& error) {
    EXPECT_THAT(error.what(), HasSubstr("cartesian: at t = 0 s the constraints permit 2 directions of motion, but only "
                                        "1 in a pose nearby, where this one is lost: "));
  }
  EXPECT_THROW(find_equilibrium(held, flat), SingularPose);
  EXPECT_THROW(linearize(held, flat, flat.assemble()), SingularPose);
  OddPendulum stuck(held, 1, 0);
  EXPECT_THROW(find_equilibrium(held, stuck), SingularPose);
}

TEST_F(AnalysesTest, APoseWithFewerMotionsThanItsNeighboursHasNoChartAroundIt) {
  const Model held = held_at_start(model_);
  OddPendulum solver(held, 1, 2);
  Chart chart(held, solver, solver.assemble());
  EXPECT_FALSE(chart.at(VecX::Constant(1, 1e-3), VecX::Zero(1)));
  EXPECT_FALSE(chart.exactly_at(VecX::Constant(1, 1e-3)));
  EXPECT_THROW(linearize(held, solver, solver.assemble()), SolverError);
}

TEST_F(AnalysesTest, AMachineThatIsHeldEverywhereHasAnEquilibriumAndNoModes) {
  const Model held = held_at_start(model_);
  OddPendulum solver(held, 0, 0);
  EXPECT_NEAR(find_equilibrium(held, solver).state.q[0](0), 0.7, 1e-14);
  EXPECT_TRUE(linearize(held, solver, solver.assemble()).modes.empty());
  Chart chart(held, solver, solver.assemble());
  EXPECT_TRUE(chart.at(VecX(0), VecX(0)).has_value());
}

TEST_F(AnalysesTest, AFreePendulumHasTwoFreeModesAndADampedOneDecays) {
  model_.gravity.setZero();
  model_.joints[0].start[0].u.setZero();
  FakePendulum still(model_, "cartesian");
  const Linearization free = linearize(model_, still, still.assemble());
  ASSERT_EQ(free.modes.size(), 2U);
  EXPECT_TRUE(free.modes[0].is_free && free.modes[1].is_free);
  EXPECT_EQ(free.modes[0].motion, "turn_z of A");
  JointSpring damper;
  damper.law.damping = 0.05;
  model_.joints[0].springs = {damper};
  FakePendulum damped(model_, "cartesian");
  const Linearization decaying = linearize(model_, damped, damped.assemble());
  ASSERT_EQ(decaying.modes.size(), 2U);
  EXPECT_TRUE(decaying.modes[0].is_free);
  EXPECT_FALSE(decaying.modes[1].is_free);
  EXPECT_NEAR(decaying.modes[1].eigenvalue.real(), -0.05 / PendulumByHand().inertia(), 1e-10);
}

Mode mode_of(std::complex<double> eigenvalue, const Eigen::VectorXcd& shape) {
  Mode mode;
  mode.eigenvalue = eigenvalue;
  mode.shape = mode.scaled_shape = shape.normalized();
  return mode;
}

TEST_F(AnalysesTest, ModesArePairedByEigenvalueAndShapeNotByTheirPlaces) {
  const Eigen::VectorXcd x = Eigen::VectorXcd::Unit(3, 0);
  const Eigen::VectorXcd y = Eigen::VectorXcd::Unit(3, 1);
  const Eigen::VectorXcd z = Eigen::VectorXcd::Unit(3, 2);
  const std::vector<Mode> one = {mode_of({0, 2.0}, x), mode_of({0, 5.0}, y), mode_of({0, 5.0 + 1e-9}, z)};
  const std::vector<Mode> other = {mode_of(1e-6, y), mode_of({0, 2.0}, x), mode_of({0, 5.0}, z),
                                   mode_of({0, 5.0 + 1e-9}, y)};
  const ModePairs pairs = pair_modes(one, other, 1e-4);
  EXPECT_EQ(pairs.both, (std::vector<std::pair<std::size_t, std::size_t>>{{0, 1}, {1, 3}, {2, 2}}));
  EXPECT_TRUE(pairs.alone[0].empty());
  EXPECT_EQ(pairs.alone[1], (std::vector<std::size_t>{0}));
}

TEST_F(AnalysesTest, JsonAndCsvHoldWrenchesOfBothSolversAndModes) {
  const Model sprung = sprung_pendulum_model();
  const AnalysisVerdict statics = judge_statics(sprung, makers());
  const ComponentCount count = count_components(statics.wrenches);
  EXPECT_EQ(count.total, 10 + 2 * 2 * 6 + 6) << "a hinge, a strut and a bushing on both ends, a load on one";
  EXPECT_EQ(count.judged, count.total);
  const auto document = nlohmann::json::parse(format_analysis_json(sprung, statics));
  EXPECT_EQ(document["total"], count.total);
  EXPECT_EQ(document["t"], (std::vector<double>{0.0}));
  ASSERT_EQ(document["wrenches"].size(), static_cast<std::size_t>(count.total));
  for (const auto& wrench : document["wrenches"]) {
    if (wrench.value("joint", "") != "A" || wrench["side"] != "child" || wrench["component"] != "F_x") continue;
    const Vec3 force =
        statics.wrenches.trajectories[1]->samples[0].evaluation.joints[0].reaction_on(Side::child).in_C.force;
    EXPECT_EQ(wrench["values"]["relative"], (std::vector<double>{force.x()}));
    EXPECT_EQ(wrench["unit"], "N");
  }
  ASSERT_EQ(document["drives"].size(), 2U) << "a spring and a damper, and not their sum";
  const auto& spring = document["drives"][0];
  EXPECT_EQ(spring["force"], "spring of joint A");
  EXPECT_EQ(spring["along"], "turn_z");
  EXPECT_EQ(spring["unit"], "N m");
  const double tau = statics.wrenches.trajectories[0]->samples[0].evaluation.joints[0].tau(0);
  EXPECT_NE(tau, 0.0);
  EXPECT_EQ(spring["values"]["cartesian"], (std::vector<double>{tau})) << "all of it is the spring's at rest";
  EXPECT_THAT(format_analysis(sprung, statics, false), HasSubstr("| spring of joint A | turn_z |"));
  const AnalysisVerdict modes = judge_linearization(model_, makers(), true);
  const std::string csv = format_modes_csv(model_, *modes.linearizations[0]);
  EXPECT_THAT(csv, HasSubstr("mode,eigenvalue.re [1/s],eigenvalue.im [1/s],frequency [Hz],damping_ratio,free,re "
                             "bob.v_x [m/s],im bob.v_x [m/s]"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 2);
}

/// Whoever asks for forces reads them, and no number where a row has many.
TEST_F(AnalysesTest, JsonHoldsTheForcesOfInverseDynamics) {
  AnalysisVerdict found;
  found.analysis = "inverse";
  found.forces.push_back({"turn_z of A", 2.5, "N m", {-4.0, -4.5}, 1.2});
  const double none = std::numeric_limits<double>::quiet_NaN();
  found.numbers.push_back({"as asked", "", {none, none}, 13.0, 9.0});
  const auto document = nlohmann::json::parse(format_analysis_json(model_, found));
  const auto& force = document["forces"][0];
  EXPECT_EQ(force["driven"], "turn_z of A");
  EXPECT_EQ(force["acceleration"], 2.5);
  EXPECT_EQ(force["unit"], "N m");
  EXPECT_EQ(force["cartesian"], -4.0);
  EXPECT_EQ(force["relative"], -4.5);
  EXPECT_TRUE(document["numbers"][0]["cartesian"].is_null());
}

}  // namespace
}  // namespace concord::compare::analyses
