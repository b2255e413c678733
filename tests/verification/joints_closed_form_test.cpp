#include <catch2/catch.hpp>

#include "closed_forms.h"

/// Joints that move on moving ground, where the relative acceleration has terms of its own: a universal joint between
/// two shafts, and a slider in a guide that turns.
namespace concord::verification {
namespace {

const Mat3 kTilted = rotation_about(Vec3(Vec3(1.0, -2.0, 0.7).normalized()), 0.9);

/// Two shafts at an angle. z is the axis of the driving one, x the normal of the plane of both. Their bearings are
/// redundant; what turns the shafts is not.
const std::string kCardanShaft = R"toml(format = 1
gravity = [1, 2, -9]
[parameters]
b = "35 deg"
[[body]]
name = "driving"
mass = 1.1
center_of_mass = [0, 0, 0.08]
inertia = [0.004, 0.005, 0.003, 0.0004, -0.0003, 0.0002]
[[body]]
name = "driven"
mass = 0.9
center_of_mass = [0, 0, -0.02]
inertia = [0.006, 0.004, 0.007, -0.0005, 0.0006, 0.0004]
[[joint]]
name = "A"
type = "revolute"
parent = { body = "ground", point = [0, 0, -0.2] }
child = "driving"
drive.turn_z = { law = "polynomial", coefficients = [0.5, 30, 40, -25] }
[[joint]]
name = "cross"
type = "universal"
parent = { body = "driving", point = [0, 0, 0.2] }
child = { body = "driven", point = [0, 0, -0.15] }
start.turn_x = { guess = "b" }
[[joint]]
name = "D"
type = "revolute"
parent = { body = "ground", point = [0, "-0.15*sin(b)", "0.15*cos(b)"], x = [1, 0, 0], z = [0, "-sin(b)", "cos(b)"] }
child = "driven"
start.turn_z = { guess = 0.45 }
)toml";

/// Hooke's joint: the yoke of the driven shaft is perpendicular to that of the driving one, so
/// tan(phi) = cos(b) tan(theta). Torques follow from the spin of the driven shaft and from equal power.
struct CardanShaft {
  double phidot, phiddot;
  Vec3 torque;  // of the cross on the driven shaft
  double tau;   // of the driver

  CardanShaft(const Model& model, const TimeFunctionValue& theta) {
    const double b = 35.0 * EIGEN_PI / 180.0;
    const double n = 1.0 - std::pow(std::sin(b) * std::sin(theta.f), 2);
    const double ratio = std::cos(b) / n;
    phidot = ratio * theta.fdot;
    phiddot = ratio * theta.fddot + ratio * std::pow(std::sin(b) * theta.fdot, 2) * std::sin(2.0 * theta.f) / n;
    const double needed = model.bodies[2].inertia_L(2, 2) * phiddot;
    tau = model.bodies[1].inertia_L(2, 2) * theta.fddot + ratio * needed;
    // The cross passes torque about its own normal only.
    const Vec3 driven_axis(0.0, -std::sin(b), std::cos(b));
    const Vec3 yoke(std::cos(theta.f), std::sin(theta.f), 0.0);
    const Vec3 normal = yoke.cross(driven_axis.cross(yoke)).normalized();
    torque = needed / normal.dot(driven_axis) * normal;
  }
};

/// A body that slides along a tilted guide on an arm that turns at a constant rate about the vertical.
const std::string kTurningGuide = R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "arm"
mass = 2.0
center_of_mass = [0.1, 0.02, -0.03]
inertia = [0.01, 0.02, 0.025]
[[body]]
name = "bead"
mass = 0.6
center_of_mass = [-0.04, 0.05, 0.01]
inertia = [0.002, 0.003, 0.004, 0.0003, -0.0002, 0.0004]
[[joint]]
name = "shaft"
type = "revolute"
parent = { body = "ground", point = [0.2, 0.3, -0.1] }
child = "arm"
drive.turn_z = { law = "constant_speed", start = 0.4, speed = 6 }
[[joint]]
name = "guide"
type = "translational"
parent = { body = "arm", point = [0.1, 0.03, 0.05], x = [0.6, -0.48, -0.64], z = [0.8, 0.36, 0.48] }
child = { body = "bead", point = [0.02, -0.01, 0.03], axis = [2, -1, 1], angle = "75 deg" }
start.slide_z = { keep = 0.12, keep_speed = -0.7 }
)toml";

/// Along the guide s'' = k^2 (s + shift), k = W times the guide's part across the axis of turning.
struct TurningGuide {
  double W = 6.0;
  Vec3 along;   // the guide, in the arm's axes
  Vec3 center;  // the bead's centre of mass at s = 0, from the axis
  Vec3 lever;   // and from the bead's point of the joint
  Mat3 inertia;
  double mass;
  Vec3 gravity;
  Mat3 frame;  // of the joint, in the arm's axes
  double s0, sdot0;

  explicit TurningGuide(const Model& model) : mass(model.bodies[2].mass), gravity(model.gravity) {
    const Body& bead = model.bodies[2];
    const Joint& guide = model.joints[1];
    frame = guide.on(Side::parent).C;
    along = frame.col(2);
    const Mat3 bead_axes = frame * guide.on(Side::child).C.transpose();
    lever = bead_axes * (bead.center_of_mass_L - guide.on(Side::child).point_L);
    center = guide.on(Side::parent).point_L + lever;
    inertia = bead_axes * bead.inertia_L * bead_axes.transpose();
    s0 = guide.start[0].q(0);
    sdot0 = guide.start[0].u(0);
  }

  [[nodiscard]] double k() const { return W * along.head<2>().norm(); }
  [[nodiscard]] double shift() const {
    return (W * W * along.head<2>().dot(center.head<2>()) + gravity.dot(along)) / (k() * k());
  }
  [[nodiscard]] double s(double t) const {
    return (s0 + shift()) * std::cosh(k() * t) + sdot0 / k() * std::sinh(k() * t) - shift();
  }
  [[nodiscard]] double sdot(double t) const {
    return (s0 + shift()) * k() * std::sinh(k() * t) + sdot0 * std::cosh(k() * t);
  }

  /// On the bead at its point, in the arm's axes.
  [[nodiscard]] Wrench on_bead(double t) const {
    const Vec3 turning(0.0, 0.0, W);
    const Vec3 acceleration = turning.cross(turning.cross(center + s(t) * along)) +
                              2.0 * sdot(t) * turning.cross(along) + k() * k() * (s(t) + shift()) * along;
    const Vec3 force = mass * (acceleration - gravity);
    return {force, turning.cross(inertia * turning) + lever.cross(force)};
  }
};

}  // namespace

TEST_CASE("A universal joint turns the driven shaft as Hooke's joint does and passes the torque that its spin needs",
          "[closed form][redundant][quick]") {
  const Model upright = parse(kCardanShaft);
  const Model model = turn_world(upright, kTilted);
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    Agreement speed;
    Agreement acceleration;
    Agreement torque;
    Agreement driver;
    for (const Sample& sample : run(*solver, 0.5, 1e-10, 200).samples) {
      const CardanShaft exact(upright, evaluate(upright.joints[0].drivers[0].law, sample.state.t));
      const Vec3 axis = model.joints[2].on(Side::parent).C.col(2);
      speed.add(sample.state.bodies[2].omega, Vec3(exact.phidot * axis));
      acceleration.add(sample.evaluation.bodies[2].omegadot, Vec3(exact.phiddot * axis));
      torque.add(sample.evaluation.joints[1].reaction_on(Side::child).in_global.torque, Vec3(kTilted * exact.torque));
      driver.add(sample.evaluation.joints[0].tau(0), exact.tau);
    }
    const double worst = std::min({speed.digits(), acceleration.digits(), torque.digits(), driver.digits()});
    tell("shafts joined by a universal joint", *solver, worst);
    CHECK(speed.digits() >= 11.0);
    CHECK(acceleration.digits() >= 11.0);
    CHECK(torque.digits() >= 11.0);
    CHECK(driver.digits() >= 11.0);
  }
}

TEST_CASE("A body in a turning guide moves by hyperbolic functions and is pushed sideways by its Coriolis force",
          "[closed form][quick]") {
  const Model upright = parse(kTurningGuide);
  const TurningGuide exact(upright);
  const Model model = turn_world(upright, kTilted);
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    Agreement place;
    Agreement speed;
    WrenchAgreement wrench(0.3);
    for (const Sample& sample : run(*solver, 0.4, 1e-12, 100).samples) {
      const double t = sample.state.t;
      place.add(sample.state.q[1](0), exact.s(t));
      speed.add(sample.state.u[1](0), exact.sdot(t));
      const Mat3 arm = kTilted * rotation_about(Axis::z, 0.4 + exact.W * t);
      const Wrench on_bead = exact.on_bead(t);
      // The guide feels it at its own point, from which the bead has slid away.
      const Wrench on_arm{-on_bead.force, -on_bead.torque - exact.s(t) * exact.along.cross(on_bead.force)};
      const JointWrenches& found = sample.evaluation.joints[1];
      wrench.add(found.reaction_on(Side::child).in_global, rotated(arm, on_bead));
      wrench.add(found.reaction_on(Side::child).in_C, rotated(exact.frame.transpose(), on_bead));
      wrench.add(found.reaction_on(Side::parent).in_global, rotated(arm, on_arm));
      wrench.add(found.reaction_on(Side::parent).in_C, rotated(exact.frame.transpose(), on_arm));
    }
    tell("body in a turning guide: path", *solver, std::min(place.digits(), speed.digits()));
    tell("body in a turning guide: reactions", *solver, wrench.digits());
    CHECK(place.digits() >= 11.0);
    CHECK(speed.digits() >= 11.0);
    CHECK(wrench.digits() >= 11.0);
  }
}

}  // namespace concord::verification
