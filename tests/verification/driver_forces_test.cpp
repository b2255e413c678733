#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "closed_forms.h"

/// What drivers, motors, springs and dampers exert on the coordinates that they share, against closed forms.
namespace concord::verification {
namespace {

constexpr double kGravity = 9.81;
constexpr double kDegree = std::numbers::pi / 180.0;

/// Angle or place, speed and acceleration of a harmonic law.
struct Motion {
  double q, u, a;
};

Motion harmonic(double amplitude, double frequency, double phase, double offset, double t) {
  const double angle = frequency * t + phase;
  return {offset + amplitude * std::sin(angle), amplitude * frequency * std::cos(angle),
          -amplitude * frequency * frequency * std::sin(angle)};
}

/// Derivative of an exact function: central differences of eighth order, whose error is round-off's.
double derivative(const std::function<double(double)>& f, double x) {
  constexpr double h = 0.02;
  constexpr std::array kWeights{4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0};
  double sum = 0.0;
  for (int k = 1; k <= 4; ++k) sum += kWeights[static_cast<std::size_t>(k - 1)] * (f(x + k * h) - f(x - k * h));
  return sum / h;
}

/// One number that an actor exerts, and its exact value at time t.
struct Exact {
  std::string joint;
  int speed;
  Actor actor;
  std::function<double(double t)> force;
};

/// Both solvers, turned with the whole world, at seven samples of a run.
void expect_shares(const std::string& name, const std::string& text, const std::vector<Exact>& expected) {
  const Mat3 Q = rotation_of(Vec4(0.8, 0.2, -0.4, 0.4).normalized());
  const Model model = turn_world(parse("format = 1\ngravity = [0, -9.81, 0]\n" + text), Q);
  for (const auto& solver : both_solvers(model)) {
    const Trajectory trajectory = run(*solver, 0.3, 1e-12, 6);
    for (const Exact& one : expected) {
      const auto joint = std::find_if(model.joints.begin(), model.joints.end(),
                                      [&](const Joint& each) { return each.name == one.joint; });
      REQUIRE(joint != model.joints.end());
      Agreement agreement;
      for (const Sample& sample : trajectory.samples) {
        const JointWrenches& wrenches =
            sample.evaluation.joints[static_cast<std::size_t>(joint - model.joints.begin())];
        agreement.add(wrenches.share_of(one.actor)(one.speed), one.force(sample.state.t));
      }
      tell(name + ", " + one.joint, *solver, agreement.digits());
      CHECK(agreement.digits() >= 10.0);
    }
  }
}

std::string body(const std::string& name, const std::string& mass, const std::string& center,
                 const std::string& inertia) {
  return "[[body]]\nname = \"" + name + "\"\nmass = " + mass + "\ncenter_of_mass = " + center +
         "\ninertia = " + inertia + "\n";
}

std::string joint(const std::string& name, const std::string& type, const std::string& rest) {
  return "[[joint]]\nname = \"" + name + "\"\ntype = \"" + type + "\"\n" + rest + "\n";
}

}  // namespace

TEST_CASE("A driver's force is told apart from spring, damper and motor on the same angle", "[quick]") {
  const auto law = [](double t) { return harmonic(0.7, 3.0, 0.4, 0.2, t); };
  const std::string text =
      body("bar", "2.0", "[0.3, -0.1, 0.05]", "[0.02, 0.05, 0.06]") +
      joint("hinge", "revolute",
            "parent = \"ground\"\nchild = \"bar\"\n"
            "drive.turn_z = { law = \"harmonic\", amplitude = 0.7, frequency = 3, phase = 0.4, offset = 0.2 }\n"
            "spring.turn_z = { stiffness = 11, damping = 0.6, free = 0.5, actuator = { law = \"harmonic\", amplitude = "
            "4, frequency = 5 } }");
  const auto spring = [=](double t) { return -11.0 * (law(t).q - 0.5); };
  const auto damper = [=](double t) { return -0.6 * law(t).u; };
  const auto motor = [](double t) { return 4.0 * std::sin(5.0 * t); };
  const auto driver = [=](double t) {
    const auto [q, u, a] = law(t);
    const double weight = 2.0 * kGravity * (0.3 * std::cos(q) + 0.1 * std::sin(q));
    return (0.06 + 2.0 * (0.3 * 0.3 + 0.1 * 0.1)) * a + weight - spring(t) - damper(t) - motor(t);
  };
  expect_shares("pendulum", text,
                {{"hinge", 0, Actor::driver, driver},
                 {"hinge", 0, Actor::spring, spring},
                 {"hinge", 0, Actor::damper, damper},
                 {"hinge", 0, Actor::motor, motor}});
}

TEST_CASE("A driver's force on a slide is told apart from a preloaded spring", "[quick]") {
  const auto law = [](double t) { return harmonic(0.2, 6.0, 1.0, 0.1, t); };
  const std::string text =
      body("block", "3.0", "[0.02, 0.1, 0.03]", "[0.02, 0.05, 0.06]") +
      joint("guide", "translational",
            "parent = { body = \"ground\", z = [0, 1, 0], x = [1, 0, 0] }\n"
            "child = { body = \"block\", z = [0, 1, 0], x = [1, 0, 0] }\n"
            "drive.slide_z = { law = \"harmonic\", amplitude = 0.2, frequency = 6, phase = 1, offset = 0.1 }\n"
            "spring.slide_z = { stiffness = 90, damping = 2, preload = 7 }");
  const auto spring = [=](double t) { return -7.0 - 90.0 * law(t).q; };
  const auto damper = [=](double t) { return -2.0 * law(t).u; };
  const auto driver = [=](double t) { return 3.0 * (law(t).a + kGravity) - spring(t) - damper(t); };
  expect_shares(
      "lift", text,
      {{"guide", 0, Actor::driver, driver}, {"guide", 0, Actor::spring, spring}, {"guide", 0, Actor::damper, damper}});
}

TEST_CASE("Motors behind couplings hold two links: the driver's share, not what couplings give back", "[quick]") {
  const std::string text =
      body("upper", "3", "[0.25, 0, 0]", "[0.005, 0.06, 0.06]") +
      body("lower", "2", "[0.2, 0, 0]", "[0.003, 0.03, 0.03]") +
      body("rotor1", "0.5", "[0, 0, 0]", "[1e-3, 1e-3, 1e-3]") +
      body("rotor2", "0.5", "[0, 0, 0]", "[1e-3, 1e-3, 1e-3]") +
      joint("j1", "revolute", "parent = \"ground\"\nchild = \"upper\"\nstart.turn_z = { guess = \"30 deg\" }") +
      joint("j2", "revolute",
            "parent = { body = \"upper\", point = [0.5, 0, 0] }\nchild = \"lower\"\n"
            "start.turn_z = { guess = \"-50 deg\" }") +
      joint("a1", "revolute",
            "parent = { body = \"ground\", point = [-0.3, 0, 0] }\nchild = \"rotor1\"\n"
            "drive.turn_z = { law = \"polynomial\", coefficients = [\"30 deg\"] }") +
      joint("a2", "revolute",
            "parent = { body = \"ground\", point = [-0.3, 0.2, 0] }\nchild = \"rotor2\"\n"
            "drive.turn_z = { law = \"polynomial\", coefficients = [\"-20 deg\"] }") +
      "[[coupling]]\nname = \"first\"\nterms = [{ joint = \"a1\", coordinate = \"turn_z\", factor = 1 }, "
      "{ joint = \"j1\", coordinate = \"turn_z\", factor = -1 }]\n"
      "[[coupling]]\nname = \"second\"\nterms = [{ joint = \"a2\", coordinate = \"turn_z\", factor = 1 }, "
      "{ joint = \"j1\", coordinate = \"turn_z\", factor = -1 }, { joint = \"j2\", coordinate = \"turn_z\", factor = "
      "-1 }]\n";
  const double upper = kGravity * (3.0 * 0.25 + 2.0 * 0.5) * std::cos(30 * kDegree);
  const double lower = kGravity * 2.0 * 0.2 * std::cos(20 * kDegree);
  expect_shares("transmission", text,
                {{"a1", 0, Actor::driver, [=](double) { return upper; }},
                 {"a2", 0, Actor::driver, [=](double) { return lower; }}});
}

TEST_CASE("A locked cylinder holds a loaded boom", "[quick]") {
  const double at = 25.0 * kDegree;
  const Vec3 foot(0.0, 1.5, 0.0);
  const Vec3 tube(0.8, 1.0, 0.0);
  const auto eye = [=](double turn) {
    return Vec3(foot +
                Vec3(1.8 * std::cos(turn) + 0.25 * std::sin(turn), 1.8 * std::sin(turn) - 0.25 * std::cos(turn), 0.0));
  };
  const auto length = [=](double turn) { return (eye(turn) - tube).norm(); };
  const auto energy = [=](double turn) {
    const Vec3 along = (eye(turn) - tube).normalized();
    return kGravity * (900.0 * (1.9 * std::sin(turn) + 0.1 * std::cos(turn)) + 80.0 * 0.6 * along.y() +
                       60.0 * (eye(turn).y() - 0.5 * along.y())) +
           5000.0 * 4.0 * std::sin(turn);
  };
  const double force = derivative(energy, at) / derivative(length, at);
  const std::string text =
      body("boom", "900.0", "[1.9, 0.1, 0]", "[50, 1500, 1500]") +
      body("tube", "80.0", "[0.6, 0, 0]", "[0.5, 10, 10]") + body("rod", "60.0", "[-0.5, 0, 0]", "[0.2, 6, 6]") +
      joint("boom_foot", "revolute",
            "parent = { body = \"ground\", point = [0, 1.5, 0] }\nchild = \"boom\"\nstart.turn_z = { guess = \"25 "
            "deg\" }") +
      joint("tube_foot", "revolute",
            "parent = { body = \"ground\", point = [0.8, 1, 0] }\nchild = \"tube\"\nstart.turn_z = { guess = \"48 "
            "deg\" }") +
      joint("piston", "translational",
            fmt::format("both = {{ z = [1, 0, 0], x = [0, 1, 0] }}\nparent = \"tube\"\nchild = \"rod\"\n"
                        "drive.slide_z = {{ law = \"polynomial\", coefficients = [{:.17g}] }}",
                        length(at))) +
      joint("rod_eye", "revolute",
            "parent = \"rod\"\nchild = { body = \"boom\", point = [1.8, -0.25, 0] }\nstart.turn_z = { guess = \"-23 "
            "deg\" }");
  // The load is told in the world, which the test turns: as a weight at the boom's tip.
  const std::string hung =
      text + fmt::format("[[body]]\nname = \"hook\"\nmass = {:.17g}\ninertia = [1, 1, 1]\n", 5000.0 / kGravity) +
      joint("shackle", "weld", "parent = { body = \"boom\", point = [4, 0, 0] }\nchild = \"hook\"");
  expect_shares("boom", hung, {{"piston", 0, Actor::driver, [=](double) { return force; }}});
}

TEST_CASE("A driven shaft turns a geared rotor and its own spring", "[quick]") {
  const auto law = [](double t) { return harmonic(1.3, 7.0, 0.3, 0.0, t); };
  const std::string text =
      body("pinion", "0.8", "[0, 0, 0.02]", "[0.01, 0.01, 0.015]") +
      body("wheel", "2.0", "[0, 0, 0.03]", "[0.1, 0.1, 0.19]") +
      joint("input", "revolute",
            "parent = \"ground\"\nchild = \"pinion\"\n"
            "drive.turn_z = { law = \"harmonic\", amplitude = 1.3, frequency = 7, phase = 0.3 }\n"
            "spring.turn_z = { stiffness = 3 }") +
      joint(
          "output", "revolute",
          "parent = { body = \"ground\", point = [0.4, 0, 0] }\nchild = \"wheel\"\nspring.turn_z = { damping = 0.4 }") +
      "[[coupling]]\nname = \"mesh\"\nterms = [{ joint = \"input\", coordinate = \"turn_z\", factor = 1 }, "
      "{ joint = \"output\", coordinate = \"turn_z\", factor = 2.5 }]\noffset = 0\n";
  const auto driver = [=](double t) {
    const auto [q, u, a] = law(t);
    return 0.015 * a + 3.0 * q + (0.19 * a + 0.4 * u) / (2.5 * 2.5);
  };
  expect_shares("gears", text,
                {{"input", 0, Actor::driver, driver},
                 {"input", 0, Actor::spring, [=](double t) { return -3.0 * law(t).q; }},
                 {"output", 0, Actor::damper, [=](double t) { return 0.4 * law(t).u / 2.5; }}});
}

TEST_CASE("A driven nut lifts its load", "[quick]") {
  const auto law = [](double t) { return harmonic(2.0, 5.0, 0.9, 0.0, t); };
  constexpr double kLead = 0.03;  // m for each radian
  const std::string text = body("nut", "1.7", "[0, 0, 0.04]", "[0.004, 0.005, 0.006]") +
                           joint("thread", "screw",
                                 "lead = 0.03\nparent = { body = \"ground\", z = [0, 1, 0], x = [1, 0, 0] }\n"
                                 "child = { body = \"nut\", z = [0, 0, 1], x = [1, 0, 0] }\n"
                                 "drive.turn = { law = \"harmonic\", amplitude = 2, frequency = 5, phase = 0.9 }");
  const auto driver = [=](double t) { return (0.006 + 1.7 * kLead * kLead) * law(t).a + 1.7 * kGravity * kLead; };
  expect_shares("nut", text, {{"thread", 0, Actor::driver, driver}});
}

TEST_CASE("Two drivers in one cylindrical joint are told one by one", "[quick]") {
  const auto turn = [](double t) { return harmonic(0.9, 4.0, 0.2, 0.3, t); };
  const auto slide = [](double t) { return harmonic(0.15, 8.0, 0.7, 0.0, t); };
  const std::string text =
      body("sleeve", "1.1", "[0, 0, 0.06]", "[0.004, 0.005, 0.006]") +
      joint("shaft", "cylindrical",
            "parent = { body = \"ground\", z = [0, 1, 0], x = [1, 0, 0] }\n"
            "child = { body = \"sleeve\", z = [0, 0, 1], x = [1, 0, 0] }\n"
            "drive.turn_z = { law = \"harmonic\", amplitude = 0.9, frequency = 4, phase = 0.2, offset = 0.3 }\n"
            "drive.slide_z = { law = \"harmonic\", amplitude = 0.15, frequency = 8, phase = 0.7 }\n"
            "spring.turn_z = { stiffness = 0.5 }\nspring.slide_z = { stiffness = 40, free = 0.1 }");
  expect_shares(
      "shaft", text,
      {{"shaft", 1, Actor::driver, [=](double t) { return 0.006 * turn(t).a + 0.5 * turn(t).q; }},
       {"shaft", 0, Actor::driver, [=](double t) { return 1.1 * (slide(t).a + kGravity) + 40.0 * (slide(t).q - 0.1); }},
       {"shaft", 0, Actor::spring, [=](double t) { return -40.0 * (slide(t).q - 0.1); }}});
}

TEST_CASE("A driver on a cut joint is told as one in the tree", "[quick]") {
  const auto law = [](double t) { return harmonic(0.4, 5.0, 0.1, 1.1, t); };
  const std::string cut = GENERATE(std::string(), std::string("cut = true\n"));
  const std::string text =
      body("left", "1.0", "[0.2, 0, 0]", "[0.01, 0.02, 0.02]") +
      body("right", "1.4", "[0.2, 0, 0]", "[0.01, 0.03, 0.03]") +
      body("bridge", "2.0", "[0.3, 0, 0]", "[0.01, 0.06, 0.06]") +
      joint("A", "revolute",
            cut +
                "parent = \"ground\"\nchild = \"left\"\n"
                "drive.turn_z = { law = \"harmonic\", amplitude = 0.4, frequency = 5, phase = 0.1, offset = 1.1 }\n"
                "spring.turn_z = { stiffness = 6, damping = 0.3 }") +
      joint("B", "revolute",
            "parent = { body = \"left\", point = [0.4, 0, 0] }\nchild = \"bridge\"\nstart.turn_z = { guess = -1.1 }") +
      joint("C", "spherical",
            "parent = { body = \"bridge\", point = [0.6, 0, 0] }\nchild = { body = \"right\", point = [0.4, 0, 0] }") +
      joint("D", "revolute",
            "parent = { body = \"ground\", point = [0.6, 0, 0] }\nchild = \"right\"\nstart.turn_z = { guess = 1.1 }");
  const auto driver = [=](double t) {
    const auto [q, u, a] = law(t);
    const double inertia = 0.02 + 0.03 + (1.0 + 1.4) * 0.2 * 0.2 + 2.0 * 0.4 * 0.4;
    const double weight = kGravity * ((1.0 + 1.4) * 0.2 + 2.0 * 0.4) * std::cos(q);
    return inertia * a + weight + 6.0 * q + 0.3 * u;
  };
  expect_shares("parallelogram", text, {{"A", 0, Actor::driver, driver}});
}

TEST_CASE("A driven crank moves a sprung slider by the power that the machine takes up", "[quick]") {
  const auto law = [](double t) { return harmonic(2.5, 4.0, 0.5, 0.3, t); };
  constexpr double kCrank = 0.15;
  constexpr double kRod = 0.45;
  const auto place = [=](double q) {
    return kCrank * std::cos(q) + std::sqrt(kRod * kRod - std::pow(kCrank * std::sin(q), 2));
  };
  const auto rod_angle = [=](double q) { return -std::asin(kCrank * std::sin(q) / kRod); };
  // Kinetic energy at unit speed of the crank, and the potential one, whose slopes are the generalized forces.
  const auto kinetic = [=](double q) {
    const double slider = derivative(place, q);
    const double rod = derivative(rod_angle, q);
    const auto x = [=](double at) { return kCrank * std::cos(at) + 0.2 * std::cos(rod_angle(at)); };
    const auto y = [=](double at) { return kCrank * std::sin(at) + 0.2 * std::sin(rod_angle(at)); };
    return 0.5 * (0.02 + 1.2 * 0.07 * 0.07 + 0.8 * (std::pow(derivative(x, q), 2) + std::pow(derivative(y, q), 2)) +
                  0.03 * rod * rod + 1.5 * slider * slider);
  };
  const auto potential = [=](double q) {
    return kGravity * (1.2 * 0.07 * std::sin(q) + 0.8 * (kCrank * std::sin(q) + 0.2 * std::sin(rod_angle(q)))) +
           0.5 * 200.0 * std::pow(place(q) - 0.5, 2);
  };
  const std::string text =
      body("crank", "1.2", "[0.07, 0, 0]", "[0.01, 0.02, 0.02]") +
      body("rod", "0.8", "[0.2, 0, 0]", "[0.01, 0.03, 0.03]") +
      body("slider", "1.5", "[0, 0, 0]", "[0.01, 0.01, 0.01]") +
      joint("main", "revolute",
            "parent = \"ground\"\nchild = \"crank\"\n"
            "drive.turn_z = { law = \"harmonic\", amplitude = 2.5, frequency = 4, phase = 0.5, offset = 0.3 }") +
      joint("pin", "revolute",
            "parent = { body = \"crank\", point = [0.15, 0, 0] }\nchild = \"rod\"\nstart.turn_z = { guess = -1.9 }") +
      joint("wrist", "spherical", "parent = { body = \"rod\", point = [0.45, 0, 0] }\nchild = \"slider\"") +
      joint("guide", "translational",
            "both = { z = [1, 0, 0], x = [0, 1, 0] }\nparent = \"ground\"\nchild = \"slider\"\n"
            "start.slide_z = { guess = 0.4 }\nspring.slide_z = { stiffness = 200, damping = 5, free = 0.5 }");
  const auto driver = [=](double t) {
    const auto [q, u, a] = law(t);
    const double slider = derivative(place, q);
    return 2.0 * kinetic(q) * a + derivative(kinetic, q) * u * u + derivative(potential, q) + 5.0 * slider * slider * u;
  };
  expect_shares("slider crank", text,
                {{"main", 0, Actor::driver, driver},
                 {"guide", 0, Actor::damper, [=](double t) { return -5.0 * derivative(place, law(t).q) * law(t).u; }}});
}

TEST_CASE("A motor alone is no driver", "[quick]") {
  const std::string text = body("rotor", "1.0", "[0, 0, 0]", "[0.02, 0.03, 0.04]") +
                           joint("bearing", "revolute",
                                 "parent = \"ground\"\nchild = \"rotor\"\nstart.turn_z = { keep = 0, keep_speed = 0 }\n"
                                 "spring.turn_z = { actuator = { law = \"polynomial\", coefficients = [0.2, 1.5] } }");
  expect_shares("motor", text, {{"bearing", 0, Actor::motor, [](double t) { return 0.2 + 1.5 * t; }}});
}

}  // namespace concord::verification
