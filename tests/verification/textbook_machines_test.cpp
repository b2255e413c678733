#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "judged_machines.h"

/// Fifteen machines as textbooks have them (rotors, cranes, linkages, vehicles, robot arms), written as a new user
/// writes them: aligned, planar, round numbers. They must agree with default settings; where a closed form is known,
/// the reactions must have it.
namespace concord::verification {
namespace {

using Vec2 = Eigen::Vector2d;

Vec2 along(double angle) { return {std::cos(angle), std::sin(angle)}; }
Vec2 across(const Vec2& v) { return {-v.y(), v.x()}; }

/// Calls look(model, solver, sample) for samples of a run by either solver.
template <class Look>
void for_runs(const std::string& name, double until, const Look& look) {
  const Model model = machine_of("textbook", name);
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    for (const Sample& sample : run(*solver, until, 1e-11, 40).samples) look(model, *solver, sample);
  }
}

const Wrench& reaction_of(const Model& model, const Sample& sample, const std::string& joint, Side side) {
  return sample.evaluation.joints[joint_named(model, joint)].reaction_on(side).in_global;
}

/// The four-bar of crank_rocker.toml by plane geometry: angles of its three links, their rates and accelerations.
struct FourBar {
  double r1 = 0.5, r2 = 0.15, r3 = 0.45, r4 = 0.35;

  struct Motion {
    std::array<double, 3> angle, rate, acceleration;  // of crank, coupler, rocker
  };

  /// The coupler's end lies where the circles about the crank's pin and the rocker's hinge meet above the ground link.
  [[nodiscard]] Motion at(double crank, double rate) const {
    const Vec2 B = r2 * along(crank);
    const Vec2 gap = Vec2(r1, 0.0) - B;
    const double c = (r3 * r3 - r4 * r4 + gap.squaredNorm()) / (2.0 * gap.norm());
    const Vec2 to_C = c * gap.normalized() + std::sqrt(r3 * r3 - c * c) * across(gap.normalized());
    const Vec2 from_D = B + to_C - Vec2(r1, 0.0);
    Motion motion{{crank, std::atan2(to_C.y(), to_C.x()), std::atan2(from_D.y(), from_D.x())}, {rate}, {0.0}};
    Eigen::Matrix2d links;
    links << across(to_C), -across(from_D);
    const Vec2 rates = links.inverse() * (-rate * across(B));
    const Vec2 bias = rate * rate * B + rates(0) * rates(0) * to_C - rates(1) * rates(1) * from_D;
    const Vec2 accelerations = links.inverse() * bias;
    for (std::size_t k = 0; k < 2; ++k) {
      motion.rate[k + 1] = rates(static_cast<Eigen::Index>(k));
      motion.acceleration[k + 1] = accelerations(static_cast<Eigen::Index>(k));
    }
    return motion;
  }

  /// Rate of kinetic energy and of potential energy of the three links: what the driver's torque does.
  [[nodiscard]] double power(const Model& model, const Motion& motion) const {
    const std::array<Vec2, 3> foot{Vec2::Zero(), r2 * along(motion.angle[0]), Vec2(r1, 0.0)};
    const std::array<Vec2, 3> foot_rate{Vec2::Zero(), motion.rate[0] * across(foot[1]), Vec2::Zero()};
    const std::array<Vec2, 3> foot_acceleration{Vec2::Zero(), -motion.rate[0] * motion.rate[0] * foot[1], Vec2::Zero()};
    double power = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Body& body = model.bodies[k + 1];
      const Vec2 e = along(motion.angle[k]);
      const Vec2 arm = body.center_of_mass_L.x() * e + body.center_of_mass_L.y() * across(e);
      const Vec2 velocity = foot_rate[k] + motion.rate[k] * across(arm);
      const Vec2 acceleration =
          foot_acceleration[k] + motion.acceleration[k] * across(arm) - motion.rate[k] * motion.rate[k] * arm;
      power += body.mass * velocity.dot(acceleration - model.gravity.head<2>()) +
               body.inertia_L(2, 2) * motion.rate[k] * motion.acceleration[k];
    }
    return power;
  }
};

TEST_CASE("Fifteen textbook machines agree over the beginning of their runs", "[textbook]") {
  const std::vector<std::string> names = machines_of("textbook");
  CHECK(names.size() == 15);
  for (const std::string& name : names) {
    const Model model = machine_of("textbook", name);
    expect_to_agree(model, in_short(model, 0.05));
  }
}

TEST_CASE("Fifteen textbook machines agree over their whole runs with default settings", "[textbook][nightly]") {
  for (const std::string& name : machines_of("textbook")) expect_to_agree(machine_of("textbook", name), {});
}

TEST_CASE("Two bearings share a rotor's unbalance m e W^2 by their levers", "[textbook][closed form]") {
  for_runs("two_bearing_rotor", 0.1, [](const Model& model, const Solver&, const Sample& sample) {
    const double turn = 150.0 * sample.state.t;
    const Vec3 pull = 12.0 * 0.0015 * 150.0 * 150.0 * Vec3(0.0, std::cos(turn), std::sin(turn));
    const Vec3 A = reaction_of(model, sample, "A", Side::parent).force;
    const Vec3 B = reaction_of(model, sample, "B", Side::parent).force;
    CHECK((A - 5.0 / 7.0 * pull).norm() < 1e-8 * pull.norm());
    CHECK((B - 2.0 / 7.0 * pull).norm() < 1e-8 * pull.norm());
  });
}

TEST_CASE("The tie rod of a wall jib crane pulls what moments about the hinge ask for", "[textbook][closed form]") {
  for_runs("wall_jib_crane", 0.1, [](const Model& model, const Solver&, const Sample& sample) {
    const double upwards = (180.0 / 2.0 + 1000.0) * 9.81;  // the tie's share at the tip
    const double outwards = upwards * 4.0 / 2.5;
    const Vec3 tie = reaction_of(model, sample, "tie", Side::child).force;
    const Vec3 hinge = reaction_of(model, sample, "hinge", Side::child).force;
    const Vec3 rope = reaction_of(model, sample, "rope", Side::child).force;
    CHECK((tie - Vec3(-outwards, 0.0, upwards)).norm() < 1e-11 * upwards);
    CHECK((hinge - Vec3(outwards, 0.0, 180.0 / 2.0 * 9.81)).norm() < 1e-11 * upwards);
    CHECK((rope - Vec3(0.0, 0.0, 9810.0)).norm() < 1e-11 * upwards);
  });
}

TEST_CASE("The block of a Scotch yoke pushes by mass, damper and spring of a harmonic motion",
          "[textbook][closed form]") {
  for_runs("scotch_yoke", 0.3, [](const Model& model, const Solver&, const Sample& sample) {
    const double r = 0.06;
    const double W = 30.0;
    const double phase = W * sample.state.t;
    const double push =
        -2.5 * W * W * r * std::cos(phase) + 800.0 * r * std::cos(phase) - 12.0 * W * r * std::sin(phase);
    const double peak = 2.5 * W * W * r;
    const Vec3 on_yoke = reaction_of(model, sample, "slot", Side::parent).force;
    CHECK(std::abs(on_yoke.x() - push) < 1e-11 * peak);
    CHECK(std::abs(on_yoke.y()) < 1e-11 * peak);
    CHECK(std::abs(sample.evaluation.joints[0].tau(0) + push * r * std::sin(phase)) < 1e-11 * peak * r);
  });
}

TEST_CASE("The driver of a crank-rocker does what the energies of its links ask for", "[textbook][closed form]") {
  const FourBar linkage;
  for_runs("crank_rocker", 0.35, [&](const Model& model, const Solver&, const Sample& sample) {
    const double W = 20.0;
    const FourBar::Motion motion = linkage.at(40.0 * EIGEN_PI / 180.0 + W * sample.state.t, W);
    CHECK(std::abs(sample.state.q[3](0) - motion.angle[2]) < 1e-12);
    CHECK(std::abs(sample.evaluation.joints[0].tau(0) - linkage.power(model, motion) / W) < 1e-10);
  });
}

}  // namespace
}  // namespace concord::verification
