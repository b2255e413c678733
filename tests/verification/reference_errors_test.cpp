#include <catch2/catch.hpp>
#include <fstream>

#include "compare/verdict/reference.h"
#include "judged_machines.h"

/// What a stated error in percent allows where the solvers and the reference say different things.
namespace concord::verification {
namespace {

/// A motor on the base drives an arm through a gear: the coupling holds the arm, and all of the motor's torque with it.
constexpr const char* kGearedArm = R"(format = 1
gravity = [0.4, -9.81, 0.3]
[[body]]
name = "arm"
mass = 3
center_of_mass = [0.25, 0.02, 0.05]
inertia = [0.02, 0.06, 0.07]
[[body]]
name = "rotor"
mass = 0.5
inertia = [1e-3, 1.2e-3, 1.3e-3]
[[joint]]
name = "elbow"
type = "revolute"
parent = { body = "ground", point = [0.1, 0.2, 0.3], axis = [0.2, 0.1, 1], angle = "10 deg" }
child = "arm"
start.turn_z = { guess = "30 deg" }
[[joint]]
name = "motor"
type = "revolute"
parent = { body = "ground", point = [-0.3, 0, 0], axis = [0.1, 0.3, 1], angle = "20 deg" }
child = "rotor"
drive.turn_z = { law = "polynomial", coefficients = ["60 deg", "40 deg"] }
[[coupling]]
name = "gear"
terms = [{ joint = "motor", coordinate = "turn_z", factor = 1 },
         { joint = "elbow", coordinate = "turn_z", factor = -2 }]
[run]
until = 0.1
)";

/// The row of a reference that states the motor's torque at the start with an error of 0.1 %.
compare::ReferenceRow against_torque(const Model& model, compare::Verdict verdict, double torque) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "concord_reference_errors.csv";
  std::ofstream(file) << "# error = 0.1 %\nt [s],motor.tau_1 [N m]\n0," << torque << "\n";
  compare::judge_reference(model, compare::read_reference(file, model), verdict);
  std::filesystem::remove(file);
  return verdict.references.at(0);
}

}  // namespace

TEST_CASE("A part of a torque that the solvers say is zero is a part of what the reference says",
          "[reference][quick]") {
  const Model model = parse_model(kGearedArm, "geared_arm.toml");
  const compare::Verdict verdict = judged(model, in_short(model, 1.0));
  INFO(compare::format_verdict(model, verdict, true));
  REQUIRE(verdict.outcome == compare::Outcome::agree);
  for (const double torque : {14.867, -3.6873}) {
    const compare::ReferenceRow row = against_torque(model, verdict, torque);
    REQUIRE(row.word != compare::ReferenceWord::not_judged);
    CHECK(row.allowed == Approx(1e-3 * std::abs(torque)));
    CHECK(row.differences[0] == Approx(std::abs(torque)));
    CHECK(row.word == compare::ReferenceWord::wrong);
  }
}

}  // namespace concord::verification
