#include <Eigen/Eigenvalues>
#include <algorithm>
#include <catch2/catch.hpp>
#include <complex>

#include "closed_forms.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/kinematics.h"
#include "compare/analyses/report.h"
#include "compare/equilibrium/equilibrium.h"

/// Statics, linearization, kinematics and inverse dynamics against numbers known from elsewhere.
namespace concord::verification {
namespace {

using compare::Equilibrium;
using compare::find_equilibrium;
using compare::held_at_start;
using compare::analyses::AnalysisVerdict;
using compare::analyses::driven_through;
using compare::analyses::format_analysis;
using compare::analyses::judge_inverse;
using compare::analyses::judge_kinematics;
using compare::analyses::judge_linearization;
using compare::analyses::judge_statics;
using compare::analyses::prescribed_coordinates;
using compare::analyses::run_kinematics;

const Mat3 kTurnedWorld = rotation_about(Vec3(Vec3(2.0, 1.0, -0.6).normalized()), 1.1);

/// Two rods in a plane whose hinges' axes are y, mass off the lines between hinges, frames tilted; in no special pose.
const std::string kDoublePendulum = R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "upper"
mass = 1.7
center_of_mass = [0.05, 0.02, -0.31]
inertia = [0.06, 0.07, 0.02, 0.001, -0.002, 0.003]
[[body]]
name = "lower"
mass = 0.9
center_of_mass = [-0.04, -0.03, -0.22]
inertia = [0.025, 0.03, 0.01, 0.0005, 0.001, -0.0007]
[[joint]]
name = "A"
type = "revolute"
parent = { body = "ground", point = [0.3, -0.2, 0.1], axis = [1, 0, 0], angle = "-90 deg" }
child = { body = "upper", axis = [1, 0, 0], angle = "-90 deg" }
start.turn_z = { keep = 0.6, keep_speed = 1.5 }
[[joint]]
name = "B"
type = "revolute"
parent = { body = "upper", point = [0.12, 0.06, -0.5], axis = [1, 0, 0], angle = "-90 deg" }
child = { body = "lower", point = [0, 0.01, 0], axis = [1, 0, 0], angle = "-90 deg" }
start.turn_z = { keep = -0.9, keep_speed = -2 }
)toml";

/// Small motions about hanging: absolute angles of both bodies, M theta'' + K theta = 0 with K diagonal.
Eigen::Vector2d double_pendulum_frequencies() {
  constexpr double g = 9.81;
  const Eigen::Vector2d c1(0.05, -0.31);  // mass centres and lower hinge from the hinge above, in the plane
  const Eigen::Vector2d c2(-0.04, -0.22);
  const Eigen::Vector2d l(0.12, -0.5);
  const double I1 = 0.07 + 1.7 * c1.squaredNorm() + 0.9 * l.squaredNorm();
  const double I2 = 0.03 + 0.9 * c2.squaredNorm();
  const Eigen::Vector2d upper = 1.7 * c1 + 0.9 * l;  // hangs straight down at rest
  const double cosine = upper.normalized().dot(l);   // how deep the lower hinge hangs then
  Eigen::Matrix2d M;
  M << I1, 0.9 * cosine * c2.norm(), 0.9 * cosine * c2.norm(), I2;
  const Eigen::Matrix2d K = Eigen::Vector2d(g * upper.norm(), 0.9 * g * c2.norm()).asDiagonal();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> solution(K, M);
  return solution.eigenvalues().cwiseSqrt();
}

TEST_CASE("A double pendulum hangs with its masses below its hinges and swings at its two frequencies",
          "[analyses][quick]") {
  const Model model = turn_world(parse(kDoublePendulum), kTurnedWorld);
  const AnalysisVerdict result = judge_linearization(model, kMakers, true);
  INFO(format_analysis(model, result, true));
  REQUIRE(result.wrenches.outcome == compare::Outcome::agree);
  const Eigen::Vector2d exact = double_pendulum_frequencies();
  for (const auto& found : result.linearizations) {
    REQUIRE(found->modes.size() == 2);
    for (int k = 0; k < 2; ++k) {
      CHECK(compare::matching_digits(found->modes[k].eigenvalue.imag() - exact(k), exact(k)) >= 11.0);
      CHECK(found->modes[k].damping_ratio() == 0.0);
    }
  }
  const Model held = held_at_start(model);
  for (const auto& solver : both_solvers(held)) {
    const Equilibrium found = find_equilibrium(held, *solver);
    const Vec3 force = found.evaluation.joints[0].reaction_on(Side::child).in_global.force;
    CHECK((force + 2.6 * model.gravity).norm() < 1e-11 * force.norm());
    CHECK(found.unstable == 0);
  }
}

TEST_CASE("A torsion pendulum turns at sqrt(k / I) and decays at c / 2 I", "[analyses][quick]") {
  const std::string text = R"toml(format = 1
gravity = [0.3, -9.7, 1.2]
[[body]]
name = "disc"
mass = 3.1
inertia = [0.04, 0.04, 0.07]
[[joint]]
name = "wire"
type = "revolute"
parent = { body = "ground", point = [0.1, 0.2, 0.3], axis = [1, 2, -1], angle = "40 deg" }
child = "disc"
start.turn_z = { keep = 1.3, keep_speed = 0 }
spring.turn_z = { stiffness = 12.5, damping = 0.2, free = "20 deg" }
)toml";
  const Model model = parse(text);
  const AnalysisVerdict result = judge_linearization(model, kMakers, true);
  INFO(format_analysis(model, result, true));
  REQUIRE(result.wrenches.outcome == compare::Outcome::agree);
  for (const auto& found : result.linearizations) {
    const std::complex<double> root(-0.2 / 0.14, std::sqrt(12.5 / 0.07 - std::pow(0.2 / 0.14, 2)));
    CHECK(std::abs(found->modes.at(0).eigenvalue - root) < 1e-11 * std::abs(root));
    CHECK(found->state.q[0](0) == Approx(20.0 * EIGEN_PI / 180.0).epsilon(1e-12));
  }
}

TEST_CASE("A slider on a slope that nothing holds is refused by name, on the level it is left and named",
          "[analyses][quick]") {
  const auto slider = [](const std::string& gravity) {
    return parse("format = 1\ngravity = " + gravity + R"toml(
[[body]]
name = "sledge"
mass = 2.0
inertia = [0.04, 0.05, 0.07]
[[joint]]
name = "rail"
type = "translational"
parent = { body = "ground", x = [0, 1, 0], z = [1, 0, 0] }
child = "sledge"
start.slide_z = { keep = 0.25, keep_speed = 0.5 }
)toml");
  };
  const Model slope = held_at_start(slider("[0.2, -9.8, 0]"));
  const Model level = held_at_start(slider("[0, -9.8, 1.0]"));
  for (const auto& solver : both_solvers(slope)) {
    CHECK_THROWS_WITH(find_equilibrium(slope, *solver), Catch::Contains("nothing resists slide_z of rail"));
  }
  for (const auto& solver : both_solvers(level)) {
    const Equilibrium found = find_equilibrium(level, *solver);
    REQUIRE(found.free.size() == 1);
    CHECK(found.free[0].name == "slide_z of rail");
    CHECK(found.state.q[0](0) == Approx(0.25).margin(1e-13));
  }
}

TEST_CASE("A driven double pendulum moves as its drivers say, with Newton's forces", "[analyses][quick]") {
  Model model = parse(kDoublePendulum);
  model.joints[0].drivers = {{0, Harmonic{0.4, 0.8, 3.0, 0.2}, 0}};
  model.joints[1].drivers = {{0, Polynomial{{-0.9, -2.0, 30.0}}, 0}};
  for (Joint& joint : model.joints) joint.start[0].role_q = joint.start[0].role_u = StartRole::unsaid;
  compare::VerifyOptions options;
  options.until = 0.8;
  options.samples = 40;
  const AnalysisVerdict result = judge_kinematics(model, kMakers, options);
  INFO(format_analysis(model, result, true));
  REQUIRE(result.wrenches.outcome == compare::Outcome::agree);
  for (const auto& run : result.wrenches.trajectories) {
    for (const Sample& sample : run->samples) {
      for (std::size_t k = 0; k < 2; ++k) {
        const TimeFunctionValue exact = evaluate(model.joints[k].drivers[0].law, sample.state.t);
        CHECK(sample.state.q[k](0) == Approx(exact.f).margin(1e-12));  // many turns, counted
        CHECK(sample.state.u[k](0) == Approx(exact.fdot).margin(1e-11));
      }
      const auto& forces = sample.evaluation.joints;
      const BodyState& lower = sample.state.bodies[2];
      const BodyAcceleration& rate = sample.evaluation.bodies[2];
      const Vec3 s = rotation_of(lower.p) * model.bodies[2].center_of_mass_L;
      const Vec3 acceleration = rate.vdot + rate.omegadot.cross(s) + lower.omega.cross(lower.omega.cross(s));
      const Vec3 force = 0.9 * (acceleration - model.gravity);
      CHECK((forces[1].reaction_on(Side::child).in_global.force - force).norm() < 1e-11 * (1.0 + force.norm()));
    }
  }
  const Model free = parse(kDoublePendulum);
  for (const auto& solver : both_solvers(free)) {
    CHECK_THROWS_WITH(run_kinematics(free, *solver, {}), Catch::Contains("2 degrees of freedom are left"));
  }
}

const auto kStarts = [](const Model& /*model*/) { return true; };

TEST_CASE("Inverse dynamics of a pendulum gives I alpha less the moment of its weight, and the way back",
          "[analyses][quick]") {
  const std::string text = R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "bob"
mass = 1.7
center_of_mass = [0.05, 0.02, -0.31]
inertia = [0.06, 0.07, 0.02, 0.001, -0.002, 0.003]
[[joint]]
name = "A"
type = "revolute"
parent = { body = "ground", point = [0.3, -0.2, 0.1], axis = [1, 0, 0], angle = "-90 deg" }
child = { body = "bob", axis = [1, 0, 0], angle = "-90 deg" }
start.turn_z = { keep = 0.6, keep_speed = 1.5 }
)toml";
  const Model model = turn_world(parse(text), kTurnedWorld);
  const AnalysisVerdict result = judge_inverse(model, kMakers, {{"A", "turn_z", 7.5}});
  INFO(format_analysis(model, result, true));
  CHECK(result.wrenches.outcome == compare::Outcome::agree);
  const double inertia = 0.07 + 1.7 * (0.05 * 0.05 + 0.31 * 0.31);
  // The hinge turns about y; x of the mass centre lifts the weight with the angle: M = -m g x_c, x_c at q = 0.6.
  const double x = 0.05 * std::cos(0.6) - 0.31 * std::sin(0.6);
  const double tau = inertia * 7.5 - 1.7 * 9.81 * x;
  const Model driven = driven_through(model, both_solvers(model)[0]->assemble(),
                                      prescribed_coordinates(model, {{"A", "turn_z", 7.5}}), kStarts);
  for (const auto& solver : both_solvers(driven)) {
    const double found = solver->evaluate(solver->assemble()).joints[0].tau(0);
    CHECK(found == Approx(tau).epsilon(1e-12));
  }
}

/// Names of the models in data/models; those of the car's variants, which take longest, only if asked for.
std::vector<std::string> shipped_models(bool variants_of_the_car) {
  std::vector<std::string> names;
  for (const auto& file : std::filesystem::directory_iterator(std::filesystem::path(CONCORD_DATA) / "models")) {
    const std::string name = file.path().stem().string();
    if (file.path().extension() == ".toml" && name.starts_with("car_") == variants_of_the_car) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

void check_analyses(const std::string& name) {
  const Model model = read(name);
  const AnalysisVerdict statics = judge_statics(model, kMakers);
  INFO(format_analysis(model, statics, true));
  CHECK(statics.wrenches.outcome == compare::Outcome::agree);
  const AnalysisVerdict start = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, start, true));
  CHECK(start.wrenches.outcome == compare::Outcome::agree);
  const AnalysisVerdict hanging = judge_linearization(model, kMakers, true);
  INFO(format_analysis(model, hanging, true));
  CHECK(hanging.wrenches.outcome == compare::Outcome::agree);
}

TEST_CASE("Both solvers find the same equilibrium, modes and forces of the shipped machines", "[analyses][quick]") {
  check_analyses(GENERATE(from_range(shipped_models(false))));
}

TEST_CASE("Both solvers find the same equilibrium and modes of the car in all its variants", "[analyses][nightly]") {
  check_analyses(GENERATE(from_range(shipped_models(true))));
}

TEST_CASE("Inverse dynamics and the way back agree to ten digits, in loops and with flexible bodies too",
          "[analyses][quick]") {
  const std::string name =
      GENERATE(as<std::string>{}, "bar_welded", "compound_pendulum", "flexible_frame_on_springs", "four_bar_with_rod",
               "hanging_chain", "hinged_link_and_piston", "joint_springs_tree", "loads_on_flexible_bodies",
               "loads_on_rigid_bodies", "mass_on_spring_damper", "motor_and_crossed_link", "slider_crank_flexible_free",
               "slider_crank_redundant", "slider_crank_rigid_free", "slider_crank_spatial_flexible",
               "slider_crank_spatial_rigid", "springs_in_a_loop", "suspension_two_rods", "turn_spring_between_yokes",
               "two_hinge_door");
  const Model model = read(name);
  const AnalysisVerdict result = judge_inverse(model, kMakers, {});
  INFO(format_analysis(model, result, true));
  CHECK(result.wrenches.outcome == compare::Outcome::agree);
}

/// The torque on the crank of a slider-crank at 0.7 rad and 15 rad/s, of which the start keeps the speed.
double torque_on_crank(StartRole of_angle, StartRole of_slide) {
  constexpr double r = 0.15;
  constexpr double L = 0.30;
  Model model = read("slider_crank_rigid_free");
  WordStart& crank = model.joints[0].start[0];
  crank.role_q = of_angle;
  crank.q(0) = 0.7;
  crank.u(0) = 15.0;
  WordStart& slider = model.joints[3].start[0];
  slider.role_q = of_slide;
  slider.q(0) = r * std::cos(0.7) + std::sqrt(L * L - std::pow(r * std::sin(0.7), 2));
  const AnalysisVerdict result = judge_inverse(model, kMakers, {});
  CHECK(result.wrenches.outcome == compare::Outcome::agree);
  return result.wrenches.trajectories[0]->samples[0].evaluation.joints[0].tau(0);
}

TEST_CASE("Inverse dynamics drives what keeps its speed though the start keeps the place of something else",
          "[analyses][quick]") {
  CHECK(torque_on_crank(StartRole::guess, StartRole::keep) ==
        Approx(torque_on_crank(StartRole::keep, StartRole::guess)).epsilon(1e-10));
}

TEST_CASE("Machines whose motion is fully driven go through it alike", "[analyses]") {
  const std::string name = GENERATE(as<std::string>{}, "driven_linkage", "slider_crank_rigid", "universal_shaft_30deg");
  const Model model = read(name);
  const AnalysisVerdict result = judge_kinematics(model, kMakers, {});
  INFO(format_analysis(model, result, true));
  CHECK(result.wrenches.outcome == compare::Outcome::agree);
}

TEST_CASE("Kinematics prints no peak of a reaction that is one of many", "[analyses][quick]") {
  Model door = read("two_hinge_door");
  door.joints[0].drivers = {{0, Polynomial{{0.1, 1.0}}, 0}};
  for (Joint& joint : door.joints) {
    for (WordStart& start : joint.start) start.role_q = start.role_u = StartRole::unsaid;
  }
  compare::VerifyOptions options;
  options.until = 0.1;
  options.samples = 4;
  const AnalysisVerdict result = judge_kinematics(door, kMakers, options);
  INFO(result.text);
  CHECK(result.wrenches.outcome == compare::Outcome::agree);
  CHECK(result.text.find("not unique") != std::string::npos);
}

/// A body that flies and spins about its axis k; no two inertias are equal.
Model spinning_stone(int k, double speed) {
  Vec3 omega = Vec3::Zero();
  omega(k) = speed;
  return parse(fmt::format(R"toml(format = 1
[[body]]
name = "stone"
mass = 2.3
inertia = [0.031, 0.052, 0.068]
[[joint]]
name = "flight"
type = "free"
parent = "ground"
child = "stone"
start.slide_x = {{ keep = 0.1, keep_speed = 0 }}
start.slide_y = {{ keep = 0.2, keep_speed = 0 }}
start.slide_z = {{ keep = 0.3, keep_speed = 0 }}
start.ball = {{ keep = {{ axis = [0, 0, 1], angle = 0 }}, keep_speed = [{}, {}, {}] }}
)toml",
                           omega(0), omega(1), omega(2)));
}

TEST_CASE("A free body that spins about a principal axis nutates, or tumbles, as Euler's equations say",
          "[analyses][quick]") {
  const Vec3 I(0.031, 0.052, 0.068);
  constexpr double speed = 9.1;
  const double largest = speed * std::sqrt((I(2) - I(0)) * (I(2) - I(1)) / (I(0) * I(1)));
  const double middle = speed * std::sqrt((I(2) - I(1)) * (I(1) - I(0)) / (I(0) * I(2)));
  const double least = speed * std::sqrt((I(1) - I(0)) * (I(2) - I(0)) / (I(1) * I(2)));
  const std::complex<double> exact[] = {{0.0, least}, {middle, 0.0}, {0.0, largest}};
  for (int k = 0; k < 3; ++k) {
    const Model model = spinning_stone(k, speed);
    const AnalysisVerdict result = judge_linearization(model, kMakers, false);
    INFO(format_analysis(model, result, true));
    CHECK(result.wrenches.outcome == compare::Outcome::agree);
    CHECK(result.text.find("frozen") == std::string::npos);
    CHECK(result.text.find("steady in axes that turn at") != std::string::npos);
    for (const auto& found : result.linearizations) {
      const auto is_it = [&](const auto& mode) { return std::abs(mode.eigenvalue - exact[k]) < 1e-8 * speed; };
      CHECK(std::count_if(found->modes.begin(), found->modes.end(), is_it) == 1);
    }
  }
}

/// A symmetric top on a ball that precesses steadily at 6.5 rad/s, leaning by 0.7 rad; its spin follows from gravity.
TEST_CASE("A top that precesses steadily nutates as its equation of lean says", "[analyses][quick]") {
  constexpr double mass = 0.8, lever = 0.11, across = 0.0061 + mass * lever * lever, along = 0.0035, lean = 0.7;
  constexpr double precession = 6.5, g = 9.81;
  const double s = std::sin(lean);
  const double c = std::cos(lean);
  const double spin =
      (across * precession * precession * c + mass * g * lever) / (along * precession);  // about its axis
  const Vec3 axis(0.0, -s, c);
  const Vec3 omega = precession * Vec3::UnitZ() + (spin - precession * c) * axis;
  const Model model = parse(fmt::format(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "top"
mass = {}
center_of_mass = [0, 0, {}]
inertia = [0.0061, 0.0061, {}]
[[joint]]
name = "tip"
type = "spherical"
parent = "ground"
child = "top"
start.ball = {{ keep = {{ axis = [1, 0, 0], angle = {} }}, keep_speed = [0, {:.17g}, {:.17g}] }}
)toml",
                                        mass, lever, along, lean, omega(1), omega(2)));
  // I1 lean'' = I1 p^2 s c - I3 w p s + m g l s, with the momenta about the vertical and the axis kept.
  const double turn_rate = along * spin / (across * s) - 2.0 * c / s * precession;  // dp/dlean
  const double slope = 2.0 * precession * turn_rate * s * c + precession * precession * std::cos(2.0 * lean) -
                       along * spin * (turn_rate * s + precession * c) / across + mass * g * lever * c / across;
  const AnalysisVerdict result = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, result, true));
  CHECK(result.wrenches.outcome == compare::Outcome::agree);
  CHECK(result.text.find("steady in axes that turn at") != std::string::npos);
  for (const auto& found : result.linearizations) {
    const std::complex<double> nutation(0.0, std::sqrt(-slope));
    const auto is_it = [&](const auto& mode) { return std::abs(mode.eigenvalue - nutation) < 1e-7 * precession; };
    CHECK(std::count_if(found->modes.begin(), found->modes.end(), is_it) == 1);
  }
}

}  // namespace
}  // namespace concord::verification
