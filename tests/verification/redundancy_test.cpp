#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/report.h"
#include "compare/report/table.h"
#include "compare/verdict/verify.h"

/// Constraints and drivers that hold the same motion twice, or nothing at all.
namespace concord::verification {
namespace {

/// A body on a hinge and, along the same line, a cylindrical joint; the coupling says that both turn alike, as they do.
constexpr const char* kCoaxial = R"(format = 1
gravity = [0, -9.81, 0]
[[body]]
name = "arm"
mass = 1
center_of_mass = [0, 0.05, 0.01]
inertia = [0.02, 0.01, 0.03]
[[joint]]
name = "hinge"
type = "revolute"
parent = { body = "ground", point = [0.1, 0.2, 0.3], axis = [1, 2, 0.5], angle = "35 deg" }
child = "arm"
start.turn_z = { keep = "20 deg", keep_speed = 1 }
[[joint]]
name = "sleeve"
type = "cylindrical"
parent = { body = "ground", point = [0.1, 0.2, 0.3], axis = [1, 2, 0.5], angle = "35 deg" }
child = { body = "arm", point = [0, 0, 0.123], axis = [0, 0, 1], angle = "17 deg" }
[[coupling]]
name = "alike"
terms = [ { joint = "hinge", coordinate = "turn_z", factor = 2 },
          { joint = "sleeve", coordinate = "turn_z", factor = -2 } ]
offset = "-34 deg"
[run]
until = 0.3
)";

/// A door on three hinges in a line: what one of them carries is not unique, what all carry is.
constexpr const char* kDoor = R"(format = 1
gravity = [0.2, 0.3, -9.81]
[[body]]
name = "door"
mass = 21
center_of_mass = [0.42, 0.02, 1.1]
inertia = [7.5, 8.2, 1.6]
[[joint]]
name = "lower"
type = "revolute"
parent = { body = "ground", point = [0.1, 0.2, 0.2] }
child = { body = "door", point = [0.1, 0.2, 0.2] }
start.turn_z = { keep = 0.1, keep_speed = 1 }
[[joint]]
name = "middle"
type = "revolute"
parent = { body = "ground", point = [0.1, 0.2, 1.1] }
child = { body = "door", point = [0.1, 0.2, 1.1] }
[[joint]]
name = "upper"
type = "revolute"
parent = { body = "ground", point = [0.1, 0.2, 1.9] }
child = { body = "door", point = [0.1, 0.2, 1.9] }
[run]
until = 0.5
)";

/// A parallelogram of which both cranks are driven, by one law.
constexpr const char* kBothCranksDriven = R"(format = 1
gravity = [0.2, -9.81, 0.4]
[[body]]
name = "left_crank"
mass = 1
center_of_mass = [0, 0.05, 0.01]
inertia = [0.002, 0.001, 0.003]
[[body]]
name = "rod"
mass = 1.3
center_of_mass = [0.15, 0.01, 0]
inertia = [0.001, 0.02, 0.02]
[[body]]
name = "right_crank"
mass = 1.1
center_of_mass = [0, 0.05, -0.01]
inertia = [0.002, 0.001, 0.003]
[[joint]]
name = "A"
type = "revolute"
parent = "ground"
child = "left_crank"
drive.turn_z = { law = "harmonic", amplitude = 0.3, frequency = 4, offset = 0.2 }
[[joint]]
name = "B"
type = "revolute"
parent = { body = "left_crank", point = [0, 0.1, 0] }
child = "rod"
[[joint]]
name = "C"
type = "spherical"
parent = { body = "rod", point = [0.3, 0, 0] }
child = { body = "right_crank", point = [0, 0.1, 0] }
[[joint]]
name = "D"
type = "revolute"
parent = { body = "ground", point = [0.3, 0, 0] }
child = "right_crank"
drive.turn_z = { law = "harmonic", amplitude = 0.3, frequency = 4, offset = 0.2 }
[run]
until = 0.5
)";

/// Two shafts and two belts of the same ratio between them; a spring turns the first shaft.
constexpr const char* kTwoBelts = R"(format = 1
[[body]]
name = "motor"
mass = 1.2
inertia = [0.02, 0.03, 0.01]
center_of_mass = [0.01, 0.02, 0.05]
[[body]]
name = "fan"
mass = 2.1
inertia = [0.05, 0.04, 0.03]
[[joint]]
name = "A"
type = "revolute"
parent = { body = "ground", point = [0.1, 0.2, 0.3], axis = [1, 2, 0.5], angle = "35 deg" }
child = "motor"
start.turn_z = { keep = 0, keep_speed = 2 }
spring.turn_z = { stiffness = 3, free = 0.4 }
[[joint]]
name = "B"
type = "revolute"
parent = { body = "ground", point = [0.4, 0.2, 0.1], axis = [1, 2, 0.5], angle = "35 deg" }
child = "fan"
[[coupling]]
name = "left belt"
terms = [ { joint = "A", coordinate = "turn_z", factor = 1 }, { joint = "B", coordinate = "turn_z", factor = -2 } ]
[[coupling]]
name = "right belt"
terms = [ { joint = "A", coordinate = "turn_z", factor = -3 }, { joint = "B", coordinate = "turn_z", factor = 6 } ]
[run]
until = 0.5
)";

TEST_CASE("How two couplings of one ratio share is open; what they exert together on each joint is unique") {
  const Model model = parse_model(kTwoBelts, "two_belts.toml");
  const auto cartesian_solver = cartesian::make_solver(model);
  const auto relative_solver = relative::make_solver(model);
  const std::string table =
      compare::format_verdict(model, compare::verify(model, *cartesian_solver, *relative_solver, {}), false);
  CHECK_THAT(table, Catch::Contains("not unique, not judged: coupling left belt: force") &&
                        Catch::Contains("not unique, not judged: coupling right belt: force") &&
                        !Catch::Contains("tau") && Catch::Contains("driver forces"));
  const State start = cartesian_solver->assemble();
  for (Solver* solver : {cartesian_solver.get(), relative_solver.get()}) {
    // By the reduced inertia: the fan turns half as fast; the belts accelerate the fan, and hold the motor back.
    const double of_motor = 0.01 + 1.2 * (0.01 * 0.01 + 0.02 * 0.02);
    const double acceleration = 3 * 0.4 / (of_motor + 0.03 / 4);
    const Evaluation at_start = solver->evaluate(start);
    CHECK(at_start.joints[0].tau(0) == Approx(of_motor * acceleration).epsilon(1e-12));
    CHECK(at_start.joints[1].tau(0) == Approx(0.03 * acceleration / 2).epsilon(1e-12));
  }
}

TEST_CASE("A coupling whose terms cancel holds nothing: both solvers count it out, and what is unique stays right") {
  const Model coupled = parse_model(kCoaxial, "coaxial.toml");
  Model free = coupled;
  free.couplings.clear();
  State start;
  for (const bool by_cartesian : {true, false}) {
    INFO((by_cartesian ? "cartesian" : "relative"));
    const auto make = by_cartesian ? cartesian::make_solver : relative::make_solver;
    const auto solver = make(coupled);
    const auto without = make(free);
    if (by_cartesian) start = solver->assemble();
    const RankReport rank = solver->rank(start);
    CHECK(rank.constraints == 10);
    CHECK(rank.rank == 5);
    CHECK(rank.degrees_of_freedom == 1);
    CHECK_FALSE(rank.undecided);
    CHECK_FALSE(rank.joints[0].unique_tau[0]);
    // The hinge alone stops the slide: its force along the axis is unique.
    CHECK(rank.joints[0].unique[0][2]);
    const Evaluation found = solver->evaluate(start);
    const Evaluation expected = without->evaluate(start);
    CHECK((found.bodies[1].omegadot - expected.bodies[1].omegadot).norm() < 1e-12 * expected.bodies[1].omegadot.norm());
    const double axial = expected.joints[0].reaction_on(Side::child).in_C.force.z();
    CHECK(std::abs(found.joints[0].reaction_on(Side::child).in_C.force.z() - axial) < 1e-12 * std::abs(axial));
  }
}

TEST_CASE("Where no reaction is unique but the total of joints is, that total gives the verdict") {
  const Model model = parse_model(kDoor, "door.toml");
  const auto cartesian_solver = cartesian::make_solver(model);
  const auto relative_solver = relative::make_solver(model);
  compare::VerifyOptions options;
  options.states = 20;
  const compare::Verdict verdict = compare::verify(model, *cartesian_solver, *relative_solver, options);
  const std::string table = compare::format_verdict(model, verdict, false);
  INFO(table);
  CHECK(verdict.outcome == compare::Outcome::agree);
  CHECK(verdict.judged == 0);
  REQUIRE(verdict.pair_sums.size() == 1);
  CHECK(verdict.pair_sums[0].samples > 0);
  CHECK(verdict.same_state.passed);
  CHECK(verdict.same_run.passed);        // by the sum of all joints on the door
  CHECK_FALSE(verdict.same_run.digits);  // totals of pairs are compared in the same state only
  CHECK(table.find("no single component is unique; judged instead: 1 total of joints that share what they carry") !=
        std::string::npos);
}

TEST_CASE("A door at rest on three hinges is judged by what they carry together") {
  const Model model = parse_model(kDoor, "door.toml");
  const compare::analyses::AnalysisVerdict rest = compare::analyses::judge_statics(model, kMakers);
  const std::string table = compare::analyses::format_analysis(model, rest, false);
  INFO(table);
  CHECK(rest.wrenches.outcome == compare::Outcome::agree);
  REQUIRE(rest.wrenches.pair_sums.size() == 1);
  CHECK(rest.wrenches.pair_sums[0].at_start[0].force.z() == Approx(21 * 9.81));
  CHECK(table.find("sum of lower + middle + upper on door") != std::string::npos);
}

TEST_CASE("Of two drivers that hold one motion neither force is unique, nor is a total wrench that they enter") {
  const Model model = parse_model(kBothCranksDriven, "both_driven.toml");
  const auto cartesian_solver = cartesian::make_solver(model);
  const auto relative_solver = relative::make_solver(model);
  const State start = cartesian_solver->assemble();
  for (const RankReport& rank : {cartesian_solver->rank(start), relative_solver->rank(start)}) {
    CHECK(rank.constraints == 20);
    CHECK(rank.rank == 18);
    for (const int driven : {0, 3}) {
      CHECK_FALSE(rank.joints[driven].unique_tau[0]);
      CHECK_FALSE(rank.joints[driven].unique_total[1][5]);
      CHECK(rank.joints[driven].unique[1][5]);  // what is left of the torque about the hinge beside the driver's
    }
    CHECK(rank.joints[1].unique_tau[0]);  // no driver: zero
  }
  const compare::Verdict verdict = compare::verify(model, *cartesian_solver, *relative_solver, {});
  INFO(compare::format_verdict(model, verdict, false));
  CHECK(verdict.outcome == compare::Outcome::agree);
  CHECK(verdict.judged < verdict.total);
  CHECK(compare::format_verdict(model, verdict, false).find("not unique, not judged: driver of joint D: tau_1") !=
        std::string::npos);
}

}  // namespace
}  // namespace concord::verification
