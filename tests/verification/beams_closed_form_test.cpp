#include <catch2/catch.hpp>
#include <numbers>

#include "closed_forms.h"

/// Flexible bodies whose deformation is known from the differential equation of the rod or beam.
namespace concord::verification {
namespace {

using std::numbers::pi;

/// The rod of data/models/slider_crank_flexible.
struct Rod {
  double length = 0.30;
  double diameter = 0.006;
  double youngs_modulus = 2.0e11;
  double density = 7870.0;

  [[nodiscard]] double mass_per_length() const { return density * 0.25 * pi * diameter * diameter; }
  /// (n pi / L)^2 sqrt(EI / (rho A)): simply supported, no rotary inertia.
  [[nodiscard]] double frequency(int n) const {
    return std::pow(n * pi / length, 2) * 0.25 * diameter * std::sqrt(youngs_modulus / density);
  }
};

/// That rod alone, tilted under gravity, its ends on pins: a ball at the first, and at the last the universal joint and
/// the slide of the slider-crank, along the rod.
const std::string kPinnedRod = R"(format = 1
gravity = [3.0, -8.0, 5.0]
[[body]]
name = "rod"
start.a = [2e-4, -5e-5]
start.adot = [0.1, 0.3]
[body.beam]
first_end = [0.04, -0.03, 0.02]
x = [6, 2, -3]
z = [2, 3, 6]
length = 0.30
elements = 40
section = { diameter = 0.006 }
youngs_modulus = 2.0e11
density = 7870
support = "simply_supported"
modes = { bending_xy = [1, 2] }
[[body]]
name = "slider"
mass = 0.0334
inertia = [1e-5, 1e-5, 1e-5]
[[joint]]
name = "B"
type = "spherical"
parent = { body = "ground", point = [0.1, 0.2, -0.3], x = [1, 2, 2], z = [2, 1, -2] }
child = { body = "rod", node = "first", axis = [1, 3, 2], angle = "40 deg" }
start.ball = { guess = { axis = [1, 1, 1], angle = 0 } }
[[joint]]
name = "C"
type = "universal"
parent = { body = "rod", node = "last", x = [2, 3, 6], z = [6, 2, -3] }
child = { body = "slider", x = [0, 0, 1], z = [1, 0, 0] }
[[joint]]
name = "D"
type = "translational"
parent = { body = "ground", point = [0.1, 0.2, -0.3], x = [2, 1, -2], z = [1, 2, 2] }
child = { body = "slider", x = [0, 0, 1], z = [1, 0, 0] }
start.slide_z = { guess = 0.30 }
)";

/// A soft bar that turns steadily about a vertical axis, rising out of the plane of turning by the angle `cone`, its
/// root at `hub` from the axis; gravity along the axis. Axial modes only.
///
/// The model: every mass point stands at its deformed place, the stiffness is that of the undeformed bar, and the bar
/// cannot bend. So with x the undeformed place, u(x) the displacement along the bar,
///   E u'' + rho (W^2 cos(cone) (hub + (x + u) cos(cone)) - g sin(cone)) = 0,  u(0) = 0,  u'(L) = 0.
/// With k = W cos(cone) sqrt(rho / E) and X0 = hub / cos(cone) - g sin(cone) / (W cos(cone))^2, that is
/// u'' + k^2 (X0 + x + u) = 0, so X0 + x + u = X0 cos(k x) + b sin(k x), b = (1/k + X0 sin(k L)) / cos(k L).
/// For hub = cone = 0 the tip moves out by tan(k L) / k - L.
struct SpinningBar {
  double hub = 0.0;   // m
  double cone = 0.0;  // rad
  double rate = 40.0;
  double gravity = 9.81;
  double length = 1.0;
  double youngs_modulus = 1.0e8;
  double density = 1200.0;
  double area = 4.0e-4;
  Mat3 world = Mat3::Identity();

  [[nodiscard]] double k() const { return rate * std::cos(cone) * std::sqrt(density / youngs_modulus); }
  [[nodiscard]] double X0() const {
    return hub / std::cos(cone) - gravity * std::sin(cone) / std::pow(rate * std::cos(cone), 2);
  }
  [[nodiscard]] double b() const { return (1.0 / k() + X0() * std::sin(k() * length)) / std::cos(k() * length); }
  /// x + u(x).
  [[nodiscard]] double place(double x) const { return X0() * std::cos(k() * x) + b() * std::sin(k() * x) - X0(); }

  /// Integral of (x + u)^power rho A dx by Gauss's rule on 50 pieces.
  [[nodiscard]] double moment(int power) const {
    constexpr std::array<double, 3> at{0.1127016653792583, 0.5, 0.8872983346207417};
    constexpr std::array<double, 3> weight{5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
    constexpr int pieces = 50;
    double sum = 0.0;
    for (int piece = 0; piece < pieces; ++piece) {
      for (int p = 0; p < 3; ++p) sum += weight[p] * std::pow(place(length * (piece + at[p]) / pieces), power);
    }
    return density * area * length / pieces * sum;
  }

  /// Axes of the bar where the hub's joint frame stands at zero: z is the axis of turning.
  [[nodiscard]] Mat3 bar_axes() const { return rotation_about(Axis::y, -cone); }

  /// What the hub does to the bar at its root, components in the hub's turning joint frame.
  [[nodiscard]] Wrench hub_wrench() const {
    const double mass = density * area * length;
    const double second = density * area * area / 12.0 * length;  // of the square section, each way
    const Mat3 axes = bar_axes();
    const Vec3 first = moment(1) * axes.col(0);
    const Mat3 moments = axes * Vec3(moment(2), second, second).asDiagonal() * axes.transpose();
    const Vec3 z = Vec3::UnitZ();
    const Vec3 root = hub * Vec3::UnitX();
    const Vec3 W = rate * z;
    const Vec3 g = -gravity * z;
    // Acceleration of a mass point at s from the root: W x (W x (root + s)). Sum of s x (W x (W x s)) over the points
    // is W^2 (sum of s s.z) x z.
    const Vec3 force = mass * (W.cross(W.cross(root)) - g) + W.cross(W.cross(first));
    const Vec3 torque = first.cross(W.cross(W.cross(root)) - g) + rate * rate * Vec3(moments * z).cross(z);
    return {force, torque};
  }

  [[nodiscard]] Model model(int modes) const {
    std::string numbers = "1";
    for (int n = 2; n <= modes; ++n) numbers += fmt::format(", {}", n);
    const std::string text =
        fmt::format(R"(format = 1
gravity = [0, 0, {:.17g}]
[[body]]
name = "bar"
[body.beam]
first_end = [0.07, 0.02, -0.05]
x = [6, 2, -3]
z = [2, 3, 6]
length = {:.17g}
elements = 200
section = {{ width_y = {:.17g}, width_z = {:.17g} }}
youngs_modulus = {:.17g}
density = {:.17g}
support = "cantilever"
modes = {{ axial = [{}] }}
damping_ratio = 0.05
[[joint]]
name = "hub"
type = "weld"
parent = {{ body = "hub", point = [{:.17g}, 0, 0] }}
child = {{ body = "bar", node = "first" }}
[[body]]
name = "hub"
mass = 0.7
inertia = [0.001, 0.002, 0.0025]
[[joint]]
name = "shaft"
type = "revolute"
parent = {{ body = "ground", point = [0.3, -0.1, 0.2] }}
child = "hub"
drive.turn_z = {{ law = "constant_speed", start = 0.6, speed = {:.17g} }}
)",
                    -gravity, length, std::sqrt(area), std::sqrt(area), youngs_modulus, density, numbers, hub, rate);
    Model made = parse(text);
    const Mat3 bar_axes_L = rotation_from_x_and_z(Vec3(6, 2, -3) / 7.0, Vec3(2, 3, 6) / 7.0);
    made.joints[0].sides[index(Side::child)].C = bar_axes_L * bar_axes().transpose();
    return turn_world(made, world);
  }
};

/// The state in which the bar's modes are at rest relative to it: Newton's method on addot(a) = 0, the Jacobian by
/// differences (exact but for round-off, since addot is linear in a).
State steady_state(Solver& solver, State state) {
  BodyState& bar = state.bodies[1];
  const auto modal_acceleration = [&] { return solver.evaluate(state).bodies[1].addot; };
  const Eigen::Index n = bar.a.size();
  for (int step = 0; step < 2; ++step) {
    const VecX a = bar.a;
    const VecX here = modal_acceleration();
    MatX jacobian(n, n);
    for (Eigen::Index m = 0; m < n; ++m) {
      bar.a = a + 1e-2 * VecX::Unit(n, m);
      jacobian.col(m) = (modal_acceleration() - here) / 1e-2;
    }
    bar.a = a - jacobian.partialPivLu().solve(here);
  }
  return state;
}

/// Digits of the tip's displacement along the bar and of the hub's wrench.
void require_stretched(const SpinningBar& bar, const std::string& what) {
  const Model model = bar.model(50);
  const Mat3X& Psi_tip = model.bodies[1].modal->nodes.back().Psi_t_L;
  const double exact = bar.place(bar.length) - bar.length;
  const Mat3 hub_axes = bar.world * rotation_about(Axis::z, 0.6);
  for (const auto& solver : both_solvers(model)) {
    INFO(what << ", " << solver->name());
    const State state = steady_state(*solver, solver->assemble());
    const double extension = Vec3(6, 2, -3).dot(Psi_tip * state.bodies[1].a) / 7.0;
    const Evaluation evaluation = solver->evaluate(state);
    CHECK(evaluation.bodies[1].addot.norm() < 1e-9 * bar.rate * bar.rate * state.bodies[1].a.norm());
    WrenchAgreement wrench(bar.length);
    const JointWrenches& hub = evaluation.joints[0];
    wrench.add(hub.reaction_on(Side::child).in_C, bar.hub_wrench());
    wrench.add(hub.reaction_on(Side::child).in_global, rotated(hub_axes, bar.hub_wrench()));
    wrench.add(hub.reaction_on(Side::parent).in_global, rotated(-hub_axes, bar.hub_wrench()));
    fmt::print("{}: tip moves by {:.9e} m, exactly {:.9e} m\n", what, extension, exact);
    tell(what + ": tip", *solver, compare::matching_digits(extension - exact, exact));
    tell(what + ": hub", *solver, wrench.digits());
    CHECK(std::abs(extension / exact - 1.0) < 1e-6);
    CHECK(wrench.digits() >= 6.0);
  }
}

/// Angular frequency of a modal coordinate from its path in the phase plane over a whole run. The plane's centre is
/// where the coordinate rests, `guess` scales it.
double measured_frequency(const Trajectory& trajectory, int mode, double rest, double guess) {
  const auto phase = [&](const Sample& sample) {
    const BodyState& rod = sample.state.bodies[1];
    return std::atan2(-rod.adot(mode) / guess, rod.a(mode) - rest);
  };
  double turned = 0.0;
  for (std::size_t n = 1; n < trajectory.samples.size(); ++n) {
    const double step = phase(trajectory.samples[n]) - phase(trajectory.samples[n - 1]);
    turned += std::remainder(step, 2.0 * pi);
  }
  return turned / trajectory.samples.back().state.t;
}

/// The rod between its pins: mode n is sqrt(2 / (rho A L)) sin(n pi x / L) and vibrates alone, since the pins hold the
/// body frame still. The reactions follow from equilibrium with inertia forces and weights at their deformed places.
struct RodBetweenPins {
  Rod rod;
  Mat3 axes;  // columns: the beam's x, y (in which it bends), z in global axes
  Vec3 gravity;
  double slider_mass;

  explicit RodBetweenPins(const Model& model) : gravity(model.gravity), slider_mass(model.bodies[2].mass) {
    axes << Vec3(1, 2, 2) / 3.0, Vec3(2, -2, 1) / 3.0, Vec3(2, 1, -2) / 3.0;
  }

  [[nodiscard]] Vec3 g() const { return axes.transpose() * gravity; }
  [[nodiscard]] double rod_mass() const { return rod.mass_per_length() * rod.length; }

  /// Integral of rho A psi_n (x / L)^power dx, power 0 or 1.
  [[nodiscard]] double integral(int n, int power) const {
    const double sign = n % 2 == 0 ? -1.0 : 1.0;
    return rod.mass_per_length() * std::sqrt(2.0 / rod_mass()) * rod.length / (n * pi) *
           (power == 0 ? 1.0 + sign : sign);
  }
  /// Modal coordinate at rest under gravity.
  [[nodiscard]] double rest(int n) const { return integral(n, 0) * g().y() / std::pow(rod.frequency(n), 2); }

  /// Wrenches at the deformation a: on the rod at B; on the slider at C; on the slider at D.
  [[nodiscard]] std::array<Wrench, 3> wrenches(const VecX& a) const {
    double inertia = 0.0;  // of the bending accelerations, and its part taken by the last end
    double inertia_at_last = 0.0;
    double first_moment = 0.0;  // of the deflection
    for (int n = 1; n <= a.size(); ++n) {
      const double addot = -std::pow(rod.frequency(n), 2) * (a(n - 1) - rest(n));
      inertia += integral(n, 0) * addot;
      inertia_at_last += integral(n, 1) * addot;
      first_moment += integral(n, 0) * a(n - 1);
    }
    const double couple = first_moment * g().x() / rod.length;  // weight along the rod on a deflected rod
    const Vec3 half_weight = 0.5 * rod_mass() * Vec3(0.0, g().y(), g().z());
    const Vec3 rod_at_C = Vec3(slider_mass * g().x(), inertia_at_last + couple, 0.0) - half_weight;
    const Vec3 rod_at_B =
        Vec3(-(slider_mass + rod_mass()) * g().x(), inertia - inertia_at_last - couple, 0.0) - half_weight;
    // The weight across the plane of bending twists the rod about its axis; the universal joint holds it.
    const Vec3 twist(first_moment * g().z(), 0.0, 0.0);
    return {rotated(axes, {rod_at_B, Vec3::Zero()}), rotated(axes, {-rod_at_C, twist}),
            rotated(axes, {rod_at_C - slider_mass * g(), -twist})};
  }
};

}  // namespace

TEST_CASE("The coupler of the model file bends at (n pi / L)^2 sqrt(EI / (rho A))", "[closed form][quick]") {
  const Rod rod;
  for (const char* name : {"slider_crank_flexible", "slider_crank_flexible_free"}) {
    const Model model = read(name);
    const ModalData& coupler = *model.bodies[2].modal;
    REQUIRE(coupler.n_modes() == 2);
    for (int n = 1; n <= 2; ++n) {
      INFO(name << ", mode " << n);
      fmt::print("{}: mode {}: {:.9g} rad/s, exactly {:.9g} rad/s, {:.1e} apart\n", name, n, coupler.frequencies(n - 1),
                 rod.frequency(n), std::abs(coupler.frequencies(n - 1) / rod.frequency(n) - 1.0));
      CHECK(std::abs(coupler.frequencies(n - 1) / rod.frequency(n) - 1.0) < 1e-6);
      // The frequency that the solvers see.
      const double mass = coupler.G(4 + 3 * (n - 1) + 1, 4 + 3 * (n - 1) + 1);
      CHECK(std::abs(std::sqrt(coupler.stiffness(n - 1, n - 1) / mass) / rod.frequency(n) - 1.0) < 1e-6);
    }
  }
}

TEST_CASE("A rod between pins vibrates at its two bending frequencies and loads the pins by inertia and weight",
          "[closed form][quick]") {
  const Model model = parse(kPinnedRod);
  const RodBetweenPins exact(model);
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    const Trajectory trajectory = run(*solver, 5.0 * 2.0 * pi / exact.rod.frequency(1), 1e-11, 200);
    for (int n = 1; n <= 2; ++n) {
      const double frequency = exact.rod.frequency(n);
      const double measured = measured_frequency(trajectory, n - 1, exact.rest(n), frequency);
      tell(fmt::format("rod between pins: frequency {}", n), *solver,
           compare::matching_digits(measured - frequency, frequency));
      CHECK(std::abs(measured / frequency - 1.0) < 1e-6);
    }
    std::vector<WrenchAgreement> joints(3, WrenchAgreement(exact.rod.length));
    for (const Sample& sample : trajectory.samples) {
      const std::array<Wrench, 3> on_child = exact.wrenches(sample.state.bodies[1].a);
      for (int k = 0; k < 3; ++k)
        joints[k].add(sample.evaluation.joints[k].total_on(Side::child).in_global, on_child[k]);
    }
    for (int k = 0; k < 3; ++k) {
      tell("rod between pins: joint " + model.joints[k].name, *solver, joints[k].digits());
      CHECK(joints[k].digits() >= 6.0);
    }
  }
}

TEST_CASE("The tip of a turning bar of 50 axial modes moves out by tan(k L)/k - L, k = W sqrt(rho / E)",
          "[closed form][quick]") {
  require_stretched({.gravity = 0.0}, "turning bar");
}

/// The tail of the modal series, terms of 1/(2n - 1)^4, is 9.5e-5 of the whole beyond the sixth.
TEST_CASE("The shipped rotating bar stays stretched by tan(k L)/k - L, but for the tail of its six modes",
          "[closed form][quick]") {
  const Model model = read("rotating_bar");
  const double k = 40.0 * std::sqrt(1200.0 / 1.0e8);
  const double exact = std::tan(k) / k - 1.0;
  const std::vector<ModalNode>& nodes = model.bodies[1].modal->nodes;
  const auto tip = std::find_if(nodes.begin(), nodes.end(), [](const ModalNode& node) { return node.name == "last"; });
  REQUIRE(tip != nodes.end());
  for (const auto& solver : both_solvers(model)) {
    for (const Sample& sample : run(*solver, 1.0, 1e-9, 40).samples) {
      if (sample.state.t < 0.5) continue;  // what the start is off by has died away
      const double found = (tip->Psi_t_L * sample.state.bodies[1].a).x();
      INFO(solver->name() << ", t = " << sample.state.t << ": " << found << " of " << exact);
      CHECK(found < exact);
      CHECK(found > (1.0 - 1.05e-4) * exact);
    }
  }
}

TEST_CASE(
    "A turning bar with offset hub and coning angle under gravity stretches and loads its hub as the rod equation "
    "says, in a tilted world",
    "[closed form][quick]") {
  require_stretched({.hub = 0.23,
                     .cone = 0.35,
                     .rate = 55.0,
                     .gravity = 300.0,
                     .world = rotation_about(Vec3(Vec3(1.0, -2.0, 0.7).normalized()), 0.9)},
                    "turning bar, offset, coned, tilted");
}

}  // namespace concord::verification
