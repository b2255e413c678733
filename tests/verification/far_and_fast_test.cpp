#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "compare/audit/balance.h"
#include "judged_machines.h"

/// Machines that drivers or gears move faster than they are looked at, that stand far from the origin, or that travel
/// far.
namespace concord::verification {
namespace {

// The work of drivers is integrated like the rest: a step as long as the time between two outputs, or a law that comes
// and goes between them, may not lose it.
// Detects round-off of what acts on a body's neighbours that is taken for a difference of the body's own small forces.
TEST_CASE("A stage that hardly anything acts on agrees beside neighbours that springs pull hard") {
  for (const std::string& name : machines_of("slides")) expect_to_agree(machine_of("slides", name), {});
}

// Detects the round-off of sums over mass points, which move as fast as modes let them while the body hardly does.
TEST_CASE("A beam that floats and vibrates agrees, though next to nothing holds it", "[quick]") {
  for (const std::string& name : machines_of("floating_beams")) expect_to_agree(machine_of("floating_beams", name), {});
}

TEST_CASE("Machines that motors and gears move fast agree and keep their energy", "[fast]") {
  for (const std::string& name : machines_of("fast")) {
    DYNAMIC_SECTION(name) {
      const Model model = machine_of("fast", name);
      compare::VerifyOptions options;
      options.states = 40;
      expect_to_agree(model, options);
    }
  }
}

// Round-off of places grows with the distance from the origin. It limits what is resolved, and is no difference.
TEST_CASE("Machines far from the origin and on long ways agree", "[far]") {
  for (const std::string& name : machines_of("far")) {
    DYNAMIC_SECTION(name) {
      const Model model = machine_of("far", name);
      compare::VerifyOptions options;
      options.states = 40;
      expect_to_agree(model, options);
    }
  }
}

// Detects an audit that takes an angle of many turns for as well known as the pose of the body.
TEST_CASE("The audit allows a wound spring what the digits of its turns leave open", "[far]") {
  const Model model = parse(R"(format = 1
[[body]]
name = "drum"
mass = 1.2
inertia = [0.011, 0.021, 0.024]
center_of_mass = [0.012, 0.018, 0.003]
[[joint]]
name = "shaft"
type = "cylindrical"
parent = { body = "ground", z = [0.2, 1, 0.1], x = [1, -0.2, 0] }
child = { body = "drum", z = [0, 1, 0], x = [1, 0, 0] }
start.turn_z = { keep = 3.1e7, keep_speed = 4.6 }
spring.turn_z = { stiffness = 1.3, free = 3.1e7 }
start.slide_z = { keep = 0.02, keep_speed = 0.1 }
[run]
until = 0.03
)");
  RunOptions options;
  options.until = model.run.until;
  options.samples = 100;
  options.rtol = 1e-8;
  const auto audited = [&](double spoiled) {
    const auto solver = relative::make_solver(model);
    compare::Auditor auditor(model);
    for (const Sample& sample : solver->integrate(options, {}).samples) {
      Evaluation evaluation = sample.evaluation;
      evaluation.joints[0].tau *= spoiled;
      auditor.add(sample.state, evaluation);
    }
    return auditor.report();
  };
  CHECK(audited(1.0).rules[static_cast<std::size_t>(compare::AuditRule::force_law)].digits > 9.0);
  CHECK(audited(1.0 + 1e-6).rules[static_cast<std::size_t>(compare::AuditRule::force_law)].digits < 7.0);
}

}  // namespace
}  // namespace concord::verification
