#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/kinematics.h"
#include "compare/analyses/report.h"
#include "compare/equilibrium/equilibrium.h"
#include "compare/report/table.h"
#include "compare/verdict/verify.h"

/// Turn springs and motors between two bodies through many turns: their angle is counted (S34).
namespace concord::verification {
namespace {

constexpr double kTurn = 2.0 * M_PI;

const Mat3 kTilted = rotation_about(Vec3(Vec3(2.0, 1.0, -0.6).normalized()), 1.1);

/// A wheel in a hub on its carrier, and an engine on a mount of its own; a driveline between engine and wheel, whose
/// sides and torque are told.
Model car_corner(const std::string& parent, const std::string& child, double torque) {
  return turn_world(parse(fmt::format(R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "engine"
mass = 120
inertia = [5, 6, 7]
[[body]]
name = "upright"
mass = 12
inertia = [0.2, 0.2, 0.2]
[[body]]
name = "wheel"
mass = 18
inertia = [0.7, 1.1, 0.7]
[[joint]]
name = "mount"
type = "weld"
parent = {{ body = "ground", point = [1, 0, 0.4] }}
child = "engine"
[[joint]]
name = "carrier"
type = "weld"
parent = {{ body = "ground", point = [0, 0.6, 0.3] }}
child = "upright"
[[joint]]
name = "hub"
type = "revolute"
both = {{ z = [0, 1, 0], x = [1, 0, 0] }}
parent = {{ body = "upright", point = [0, 0.1, 0] }}
child = "wheel"
start.turn_z = {{ keep = 0, keep_speed = 0 }}
[[turn_spring]]
name = "driveline"
both = {{ z = [0, 1, 0], x = [1, 0, 0] }}
parent = "{}"
child = "{}"
actuator = {}
)toml",
                                      parent, child, torque)),
                    kTilted);
}

/// Two flywheels about one tilted axis, each on a joint with ground, and a coil between them; one is said on the other
/// side of the coil where the sides are swapped.
std::string flywheels(const std::string& type, bool swapped, double speed, const std::string& law) {
  const auto body = [&](int k, double inertia, double omega) {
    const std::string start = type == "revolute"
                                  ? fmt::format("start.turn_z = {{ keep = 0, keep_speed = {} }}\n", omega)
                                  : fmt::format(
                                        "start.slide_x = {{ keep = 0, keep_speed = 0 }}\n"
                                        "start.slide_y = {{ keep = 0, keep_speed = 0 }}\n"
                                        "start.slide_z = {{ keep = 0, keep_speed = 0 }}\n"
                                        "start.ball = {{ keep = {{ euler_parameters = [1, 0, 0, 0] }}, "
                                        "keep_speed = [0, 0, {}] }}\n",
                                        omega);
    return fmt::format(
        "[[body]]\nname = \"wheel_{0}\"\nmass = {1}\ninertia = [0.3, 0.3, {2}]\n"
        "[[joint]]\nname = \"bearing_{0}\"\ntype = \"{3}\"\n"
        "parent = {{ body = \"ground\", point = [0.1, 0.2, {0}], axis = [1, 2, 0.5], angle = 0.8 }}\n"
        "child = \"wheel_{0}\"\n{4}",
        k, 2 + k, inertia, type, start);
  };
  return "format = 1\ngravity = [0, 0, 0]\n" + body(1, 0.4, -0.5 * speed) + body(2, 0.1, 2.0 * speed) +
         fmt::format("[[turn_spring]]\nname = \"coil\"\nparent = \"wheel_{}\"\nchild = \"wheel_{}\"\n{}",
                     swapped ? 2 : 1, swapped ? 1 : 2, law);
}

/// A rotor in a tilted bearing that a motor turns against a coil with ground.
std::string wound_rotor(const std::string& of_bearing, const std::string& of_coil) {
  return "format = 1\n[[body]]\nname = \"rotor\"\nmass = 2\ninertia = [0.3, 0.3, 0.4]\n"
         "[[joint]]\nname = \"bearing\"\ntype = \"revolute\"\n"
         "parent = { body = \"ground\", axis = [1, 2, 0.5], angle = 0.8 }\nchild = \"rotor\"\n" +
         of_bearing +
         "[[turn_spring]]\nname = \"coil\"\n"
         "parent = { body = \"ground\", axis = [1, 2, 0.5], angle = 0.8 }\nchild = \"rotor\"\n" +
         of_coil;
}

/// A body that flies and tumbles, another on a ball on it, and a coil between them in tilted frames.
constexpr std::string_view kTumblingPair = R"toml(format = 1
gravity = [0.3, -1, 0.2]
[[body]]
name = "one"
mass = 3
inertia = [0.2, 0.3, 0.4]
center_of_mass = [0.02, 0.01, 0]
[[body]]
name = "two"
mass = 0.5
inertia = [0.02, 0.03, 0.04]
center_of_mass = [0.01, 0.01, 0]
[[joint]]
name = "one"
type = "free"
parent = "ground"
child = "one"
start.slide_x = {{ keep = 0, keep_speed = 0.1 }}
start.slide_y = {{ keep = 0, keep_speed = 0.1 }}
start.slide_z = {{ keep = 0, keep_speed = 0.1 }}
start.ball = {{ keep = {{ euler_parameters = [1, 0.1, 0, 0.3] }}, keep_speed = [0.1, 0.2, -3] }}
[[joint]]
name = "two"
type = "spherical"
parent = {{ body = "one", point = [0.5, 0, 0] }}
child = "two"
start.ball = {{ keep = {{ euler_parameters = [0.99, 0.1, 0, 0.1] }}, keep_speed = [0.1, 0.2, {}]}}
[[turn_spring]]
name = "coil"
parent = {{ body = "one", axis = [1, 0.3, 0], angle = 0.3 }}
child = "two"
stiffness = 0.02
damping = 0.001
{}_stop = {{ at = {}, stiffness = 1, width = 0.3 }}
)toml";

}  // namespace

TEST_CASE("A motor between two bodies turns one through many turns and loads the mount of the other, not the hub",
          "[closed form][forces][turns][quick]") {
  const bool swapped = GENERATE(false, true);
  const double torque = GENERATE(200.0, -200.0);
  const Model model = swapped ? car_corner("wheel", "engine", torque) : car_corner("engine", "wheel", torque);
  const double alpha = (swapped ? torque : -torque) / 1.1;
  const Vec3 axis = kTilted.col(1);
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name() << (swapped ? ", swapped, " : ", ") << torque);
    Agreement turned;
    Agreement mount;
    double hub = 0.0;
    for (const Sample& sample : run(*solver, 2.0, 1e-12, 3).samples) {
      const double angle = 0.5 * alpha * sample.state.t * sample.state.t;
      turned.add(sample.state.spring_angles.at(0), swapped ? -angle : angle);
      // The engine is turned by what turns the wheel, the other way; the mount holds it.
      mount.add(sample.evaluation.joints[0].reaction_on(Side::child).in_global.torque, Vec3(1.1 * alpha * axis));
      hub = std::max(hub, std::abs(sample.evaluation.joints[2].reaction_on(Side::child).in_C.torque.z()));
    }
    CHECK(turned.digits() >= 10.5);
    CHECK(mount.digits() >= 11.0);
    CHECK(hub < 1e-9);
  }
}

TEST_CASE("A coil between two flywheels that turn freely winds over three turns either way as an oscillator does",
          "[closed form][forces][turns][quick]") {
  const std::string type = GENERATE(as<std::string>{}, "revolute", "free");
  const bool swapped = GENERATE(false, true);
  const double way = GENERATE(1.0, -1.0);
  constexpr double kStiffness = 3.0;
  const double inertia = 0.4 * 0.1 / 0.5;
  const double rate = std::sqrt(kStiffness / inertia);
  const double reach = 3.3 * kTurn;
  const double speed = way * reach * rate / 2.5;  // wheel_2 at twice that, wheel_1 back at half of it
  const Model model = parse(flywheels(type, swapped, speed, fmt::format("stiffness = {}\n", kStiffness)));
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name() << ", " << type << (swapped ? ", swapped, " : ", ") << way);
    Agreement angle;
    Agreement torque;
    for (const Sample& sample : run(*solver, 2.0, 1e-12, 40).samples) {
      const double x = way * reach * std::sin(rate * sample.state.t);  // of wheel_2 against wheel_1
      angle.add(sample.state.spring_angles.at(0), swapped ? -x : x);
      const ElementWrenches& coil = sample.evaluation.elements[0];
      torque.add(coil.on_side(swapped ? Side::parent : Side::child).in_C.torque, Vec3(0.0, 0.0, -kStiffness * x));
      torque.add(coil.on_side(swapped ? Side::child : Side::parent).in_C.torque, Vec3(0.0, 0.0, kStiffness * x));
    }
    tell("coil between flywheels: angle", *solver, angle.digits());
    CHECK(angle.digits() >= 11.0);
    CHECK(torque.digits() >= 10.0);
  }
}

TEST_CASE("The verdict agrees on a coil that tumbling bodies wind over many turns against a stop beyond the first one",
          "[verdict][turns][quick]") {
  const double way = GENERATE(1.0, -1.0);
  const Model model = parse(fmt::format(kTumblingPair, way * 25.0, way > 0.0 ? "upper" : "lower", way * 12.0));
  compare::VerifyOptions options;
  options.until = 1.0;
  const auto cartesian = kMakers.cartesian(model);
  const auto relative = kMakers.relative(model);
  const compare::Verdict verdict = compare::verify(model, *cartesian, *relative, options);
  INFO(compare::format_verdict(model, verdict, false));
  CHECK(verdict.outcome == compare::Outcome::agree);
  for (const auto& trajectory : verdict.trajectories) {
    REQUIRE(trajectory);
    double most = 0.0;
    for (const Sample& sample : trajectory->samples) most = std::max(most, way * sample.state.spring_angles.at(0));
    CHECK(most > 12.0);
  }
}

TEST_CASE("A rotor comes to rest where its coil, wound beyond two turns, balances its motor, and swings there",
          "[closed form][analyses][turns][quick]") {
  constexpr double kMotor = 40.0;
  constexpr double kStiffness = 2.0;
  constexpr double kOfStop = 50.0;
  constexpr double kAt = 2.25 * kTurn;
  constexpr double kWidth = 0.02;
  const double way = GENERATE(1.0, -1.0);
  const Model model = parse(
      wound_rotor(fmt::format("start.turn_z = {{ keep = 0.3, keep_speed = 0 }}\nspring.turn_z = {{ actuator = {} }}\n",
                              way * kMotor),
                  fmt::format("stiffness = {}\n{}_stop = {{ at = {}, stiffness = {}, width = {} }}\n", kStiffness,
                              way > 0.0 ? "upper" : "lower", way * kAt, kOfStop, kWidth)));
  // A stop that is pressed beyond its width pushes as if from half of it.
  const double rest = (kMotor + kOfStop * (kAt + 0.5 * kWidth)) / (kStiffness + kOfStop);
  REQUIRE(rest > kAt + kWidth);
  const auto statics = compare::analyses::judge_statics(model, kMakers);
  INFO(compare::analyses::format_analysis(model, statics, true));
  CHECK(statics.wrenches.outcome == compare::Outcome::agree);
  for (const auto& make : {kMakers.cartesian, kMakers.relative}) {
    const Model held = compare::held_at_start(model);
    const std::unique_ptr<Solver> solver = make(held);
    const State at = compare::find_equilibrium(held, *solver).state;
    CHECK(at.q[0](0) == Approx(way * rest).epsilon(1e-10));
    CHECK(at.spring_angles.at(0) == Approx(way * rest).epsilon(1e-10));
  }
  const auto modes = compare::analyses::judge_linearization(model, kMakers, true);
  const std::string text = compare::analyses::format_analysis(model, modes, true);
  INFO(text);
  CHECK(modes.wrenches.outcome == compare::Outcome::agree);
  CHECK(text.find(fmt::format("{:.10g}", std::sqrt((kStiffness + kOfStop) / 0.4) / kTurn)) != std::string::npos);
}

TEST_CASE("A driver that winds a coil through three turns needs the torque of all of them",
          "[closed form][analyses][turns][quick]") {
  const Model model =
      parse(wound_rotor("drive.turn_z = { law = \"constant_speed\", speed = -19 }\n", "stiffness = 2\nfree = 0.5\n"));
  compare::VerifyOptions options;
  options.until = 1.0;
  const auto result = compare::analyses::judge_kinematics(model, kMakers, options);
  INFO(compare::analyses::format_analysis(model, result, true));
  CHECK(result.wrenches.outcome == compare::Outcome::agree);
  for (const auto& trajectory : result.wrenches.trajectories) {
    const Sample& last = trajectory->samples.back();
    CHECK(last.evaluation.joints[0].tau(0) == Approx(2.0 * (-19.0 - 0.5)).epsilon(1e-10));
  }
}

TEST_CASE("Ends that start half a turn apart have the angle pi on either side of round-off",
          "[closed form][forces][turns][quick]") {
  const double off = GENERATE(0.0, 1e-15, -1e-15, 1e-9, -1e-9);
  const Model model = parse(
      wound_rotor(fmt::format("start.turn_z = {{ keep = {:.17g}, keep_speed = 0 }}\n", M_PI + off), "stiffness = 2\n"));
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name() << ", " << off);
    const State start = solver->assemble();
    CHECK(start.spring_angles.at(0) == Approx(M_PI).epsilon(1e-8));
    CHECK(solver->evaluate(start).elements[0].on_side(Side::child).in_C.torque.z() ==
          Approx(-2.0 * M_PI).epsilon(1e-8));
  }
}

}  // namespace concord::verification
