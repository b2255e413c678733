#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "judged_machines.h"

/// Force laws and a screw against what their statement says by hand: stops, tables, preload, a nut on its thread.
namespace concord::verification {
namespace {

/// A body on a guide that stands askew to everything, without gravity: x is how far it has slid.
std::string on_a_guide(const std::string& start, const std::string& law, const std::string& gravity = "[0, 0, 0]") {
  return R"toml(format = 1
gravity = )toml" +
         gravity + R"toml(
[[body]]
name = "bob"
mass = 1.7
center_of_mass = [0.1, -0.05, 0.08]
inertia = [0.02, 0.03, 0.025, 0.002, -0.001, 0.003]
[[joint]]
name = "guide"
type = "translational"
parent = { body = "ground", point = [0.3, -0.1, 0.2], rotation_vector = [0.4, -0.7, 0.3] }
child = { body = "bob", point = [0.02, 0.04, -0.03], rotation_vector = [-0.3, 0.2, 0.9] }
start.slide_z = )toml" +
         start + "\n[joint.spring.slide_z]\n" + law + "\n";
}

constexpr double kMass = 1.7;

double position_of(const Sample& sample) { return sample.state.q[0](0); }
double speed_of(const Sample& sample) { return sample.state.u[0](0); }

/// Energy of a stop that is pressed by p, in units of its stiffness: the integral of the integral of the share
/// z^2 (3 - 2 z), z = p / width; beyond the width the share is 1.
double stop_energy(double p, double width) {
  if (p <= 0.0) return 0.0;
  const double z = std::min(p / width, 1.0);
  const double soft = width * width * (std::pow(z, 4) / 4.0 - std::pow(z, 5) / 10.0);
  return soft + (p > width ? 0.5 * (p - width) * (p - width) + 0.5 * width * (p - width) : 0.0);
}

}  // namespace

TEST_CASE("An undamped stop returns what it took, along its own energy", "[closed form][laws][quick]") {
  const Model model = parse(on_a_guide("{ keep = -0.05, keep_speed = 2.5 }",
                                       "upper_stop = { at = 0.11, stiffness = 4e3, width = 0.03 }\n"
                                       "lower_stop = { at = -0.2, stiffness = 9e3, width = 0.02 }"));
  const double energy = 0.5 * kMass * 2.5 * 2.5;
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    Agreement kept;
    double deepest = 0.0;
    for (const Sample& sample : run(*solver, 1.0, 1e-12, 400).samples) {
      const double x = position_of(sample);
      const double stored = 4e3 * stop_energy(x - 0.11, 0.03) + 9e3 * stop_energy(-0.2 - x, 0.02);
      kept.add(0.5 * kMass * speed_of(sample) * speed_of(sample) + stored, energy);
      deepest = std::max(deepest, x - 0.11);
    }
    tell("undamped stops: energy", *solver, kept.digits());
    CHECK(kept.digits() >= 11.0);
    CHECK(deepest > 0.04);  // in full, beyond the width
  }
}

TEST_CASE("A damped stop pushes only, lets go in the middle of the rebound, and both solvers see when",
          "[closed form][laws][quick]") {
  const Model model = parse(on_a_guide("{ keep = 0, keep_speed = 2 }",
                                       "upper_stop = { at = 0.1, stiffness = 3e3, damping = 40, width = 0.02 }"));
  std::vector<double> left_at;
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    double most_pull = 0.0;
    bool rode_free_while_pressed = false;
    const Trajectory found = run(*solver, 0.4, 1e-12, 800);
    for (const Sample& sample : found.samples) {
      const double tau = sample.evaluation.joints[0].tau(0);
      most_pull = std::max(most_pull, tau);
      if (position_of(sample) > 0.1 && speed_of(sample) < 0.0 && tau == 0.0) rode_free_while_pressed = true;
    }
    CHECK(most_pull == 0.0);
    CHECK(rode_free_while_pressed);
    left_at.push_back(speed_of(found.samples.back()));
    CHECK(left_at.back() < -0.5);
    CHECK(left_at.back() > -1.9);
  }
  CHECK(std::abs(left_at[0] - left_at[1]) < 1e-10);
}

TEST_CASE("On a stop rests what weighs, by the depth at which the stop carries it", "[closed form][laws][quick]") {
  // Along the guide's own axis: in full the straight part of the stop stands half its width behind its place.
  const Mat3 C = rotation_about(Vec3(Vec3(0.4, -0.7, 0.3).normalized()), Vec3(0.4, -0.7, 0.3).norm());
  const Vec3 g = 9.0 * C.col(2);
  const double depth = kMass * 9.0 / 800.0 + 0.5 * 0.01;
  const Model model = parse(on_a_guide(fmt::format("{{ keep = {:.17g}, keep_speed = 0 }}", 0.07 + depth),
                                       "upper_stop = { at = 0.07, stiffness = 800, damping = 30, width = 0.01 }",
                                       fmt::format("[{:.17g}, {:.17g}, {:.17g}]", g.x(), g.y(), g.z())));
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    for (const Sample& sample : run(*solver, 0.5, 1e-11, 20).samples) {
      CHECK(std::abs(position_of(sample) - 0.07 - depth) < 1e-12);
      CHECK(std::abs(sample.evaluation.joints[0].tau(0) + kMass * 9.0) < 1e-10);
    }
  }
}

TEST_CASE("A table through a cubic is that cubic, and keeps its energy", "[closed form][laws][quick]") {
  // F = 60 s + 900 s^3 at s = x - 0.05.
  std::string forces;
  std::string places;
  for (const double s : {-0.5, -0.31, -0.1, 0.02, 0.2, 0.33, 0.6}) {
    places += fmt::format("{}{}", places.empty() ? "" : ", ", s);
    forces += fmt::format("{}{:.17g}", forces.empty() ? "" : ", ", 60.0 * s + 900.0 * s * s * s);
  }
  const Model model =
      parse(on_a_guide("{ keep = 0.35, keep_speed = -0.4 }",
                       fmt::format("free = 0.05\nspring_table = {{ x = [{}], force = [{}] }}", places, forces)));
  const auto energy = [](double x, double v) {
    const double s = x - 0.05;
    return 0.5 * kMass * v * v + 30.0 * s * s + 225.0 * s * s * s * s;
  };
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    Agreement kept;
    for (const Sample& sample : run(*solver, 2.0, 1e-12, 100).samples) {
      kept.add(energy(position_of(sample), speed_of(sample)), energy(0.35, -0.4));
    }
    tell("table of a cubic: energy", *solver, kept.digits());
    CHECK(kept.digits() >= 11.0);
  }
}

TEST_CASE("A preloaded spring swings about where its tension vanishes", "[closed form][laws][quick]") {
  // Tension 12 + 150 (x - 0.2): zero at x = 0.12.
  const Model model =
      parse(on_a_guide("{ keep = 0.3, keep_speed = 0.7 }", "stiffness = 150\nfree = 0.2\npreload = 12"));
  const double W = std::sqrt(150.0 / kMass);
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    Agreement path;
    Agreement force;
    for (const Sample& sample : run(*solver, 3.0, 1e-12, 100).samples) {
      const double t = sample.state.t;
      const double exact = 0.12 + 0.18 * std::cos(W * t) + 0.7 / W * std::sin(W * t);
      path.add(position_of(sample), exact);
      force.add(sample.evaluation.joints[0].tau(0), -150.0 * (exact - 0.12));
    }
    tell("preloaded spring: path", *solver, path.digits());
    CHECK(path.digits() >= 10.5);
    CHECK(force.digits() >= 10.0);
  }
}

TEST_CASE("A mass that swings thousands of times keeps its phase: equal steps do not add up their round-off of time",
          "[closed form][laws][quick]") {
  constexpr double kStiffness = 1.7e8;  // N/m
  const double omega = std::sqrt(kStiffness / kMass);
  const Model model = parse(on_a_guide("{ keep = 0.4, keep_speed = 0 }", "stiffness = 1.7e8"));
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    Agreement place;
    Agreement speed;
    for (const Sample& sample : run(*solver, 0.5, 1e-12, 7).samples) {
      place.add(position_of(sample), 0.4 * std::cos(omega * sample.state.t));
      speed.add(speed_of(sample), -0.4 * omega * std::sin(omega * sample.state.t));
    }
    tell("thousands of swings: place", *solver, place.digits());
    tell("thousands of swings: speed", *solver, speed.digits());
    CHECK(place.digits() >= 10.0);
    CHECK(speed.digits() >= 10.0);
  }
}

TEST_CASE(
    "A law of many periods is followed as far as the round-off of time lets it, at no more cost for a tolerance "
    "beyond that",
    "[closed form][laws][quick]") {
  constexpr double kOmega = 1e4;  // rad/s
  constexpr double kForce = 5e3;
  const Model model = parse(on_a_guide("{ keep = 0, keep_speed = 0 }",
                                       "actuator = { law = \"harmonic\", amplitude = 5e3, frequency = 1e4 }"));
  constexpr double kMost = kForce / (kMass * kOmega);
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    std::array<long, 2> evaluations{};
    std::array<double, 2> digits{};
    for (std::size_t k = 0; k < 2; ++k) {
      const Trajectory found = run(*solver, 0.5, k == 0 ? 1e-10 : 1e-13, 7);
      Agreement speed;
      for (const Sample& sample : found.samples)
        speed.add(speed_of(sample), kMost * (1.0 - std::cos(kOmega * sample.state.t)));
      digits[k] = speed.digits();
      evaluations[k] = found.statistics.evaluations;
      tell("a law of many periods: speed", *solver, speed.digits());
    }
    CHECK(digits[0] >= 9.5);
    CHECK(digits[1] >= 9.5);
    INFO(evaluations[0] << " " << evaluations[1]);
    CHECK(evaluations[1] <= 3 * evaluations[0]);
  }
}

TEST_CASE("A nut runs down its thread at a constant rate, and the thread carries T = -lead F",
          "[closed form][laws][quick]") {
  // The centre of mass is on the axis: (I + m h^2) qddot = m g_z h.
  const Model model = parse(R"toml(format = 1
gravity = [1, -2, -9]
[[body]]
name = "nut"
mass = 0.8
center_of_mass = [0, 0, 0.06]
inertia = [0.004, 0.004, 0.0025]
[[joint]]
name = "thread"
type = "screw"
lead = 0.03
parent = { body = "ground", point = [0.1, 0.2, 0.3] }
child = "nut"
start.turn = { keep = "500 deg", keep_speed = -4 }
)toml");
  const double h = 0.03;
  const double alpha = 0.8 * -9.0 * h / (0.0025 + 0.8 * h * h);
  const double q0 = 500.0 * EIGEN_PI / 180.0;
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    Agreement path;
    Agreement thrust;
    Agreement torque;
    for (const Sample& sample : run(*solver, 0.8, 1e-12, 80).samples) {
      const double t = sample.state.t;
      path.add(position_of(sample), q0 - 4.0 * t + 0.5 * alpha * t * t);
      const Wrench on_nut = sample.evaluation.joints[0].reaction_on(Side::child).in_global;
      const double F_z = 0.8 * (h * alpha + 9.0);
      thrust.add(on_nut.force.z(), F_z);
      torque.add(on_nut.torque.z(), -h * F_z);
    }
    tell("nut on a thread: turn", *solver, path.digits());
    tell("nut on a thread: thrust and torque", *solver, std::min(thrust.digits(), torque.digits()));
    CHECK(path.digits() >= 10.5);
    CHECK(thrust.digits() >= 12.0);
    CHECK(torque.digits() >= 12.0);
  }
}

// Detects a budget that forgets what cancels: the driver's force is known to round-off of what pushes against it.
TEST_CASE("A driver moves a block against an actuator, a table or a stop, and all it carries agrees", "[laws][quick]") {
  const std::string against =
      GENERATE(as<std::string>(), "{ actuator = 1e4 }", "{ upper_stop = { at = 0, stiffness = 1e7, width = 1e-3 } }",
               "{ spring_table = { x = [-1, -0.3, 0.2, 1], force = [3e6, 1e6, -1e6, -3e6] } }",
               "{ damper_table = { x = [-1, -0.3, 0.2, 1], force = [3e6, 1e6, -1e6, -3e6] } }");
  const std::string joint =
      GENERATE(as<std::string>(), "type = \"translational\"\ndrive.slide_z", "type = \"revolute\"\ndrive.turn_z");
  const std::string coordinate = joint.find("slide") != std::string::npos ? "slide_z" : "turn_z";
  INFO(coordinate << " against " << against);
  const Model model = parse(R"toml(format = 1
gravity = [0, 0, -1]
[[body]]
name = "block"
mass = 1
inertia = [0.1, 0.1, 0.1]
[[joint]]
name = "guide"
parent = "ground"
child = "block"
)toml" + joint + " = { law = \"harmonic\", amplitude = 0.1, frequency = 6 }\nspring." +
                            coordinate + " = " + against + "\n");
  expect_to_agree(model, in_short(model, 1.0));
}

}  // namespace concord::verification
