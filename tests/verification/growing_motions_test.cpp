#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "compare/report/table.h"
#include "compare/verdict/verify.h"

/// Motions of a model that grow without bound, beyond all that it can mean.
namespace concord::verification {
namespace {

using compare::Outcome;
using compare::Verdict;

/// Spun at 31 rad/s, in its plane softer than that, as no model has geometric stiffness: at 27.8 rad/s it stays where
/// it is, and above it leaves by exp(13.7 t / s).
const char* const kBladeThatLeaves = R"toml(format = 1
[[body]]
name = "blade"
start.a = [0.001, 0.0, 0.0]
[body.beam]
first_end = [0.1, -0.2, 0.05]
x = [0.6, 0, 0.8]
z = [0, 1, 0]
length = 1.2
section = { area = 1e-3, second_moment_y = 5e-9, second_moment_z = 5e-9, torsion_constant = 1e-8 }
youngs_modulus = 7e10
shear_modulus = 2.6e10
density = 2700
support = "cantilever"
modes = { bending_xy = [1], bending_xz = [1], axial = [1] }
[[joint]]
name = "root"
type = "revolute"
parent = { body = "ground", point = [0.3, 0.1, 0.2], x = [0.8, -0.6, 0], z = [0.48, 0.64, 0.6] }
child = { body = "blade", node = "first", x = [0.6, 0, 0.8], z = [0, 1, 0] }
drive.turn_z = { law = "polynomial", coefficients = [0.3, 31] }
[run]
until = 6
)toml";

const char* const kBoxThatIsPushedOff = R"toml(format = 1
gravity = [0.3, -9.8, 0.2]
[[body]]
name = "box"
mass = 1.3
center_of_mass = [0.1, 0.02, -0.03]
inertia = [0.1, 0.11, 0.12]
[[joint]]
name = "rail"
type = "translational"
parent = { body = "ground", point = [0.3, 0.1, 0.2], x = [0.8, -0.6, 0], z = [0.48, 0.64, 0.6] }
child = { body = "box", point = [0.1, -0.3, 0.2], x = [0.6, 0, 0.8], z = [0, 1, 0] }
start.slide_z = { keep = 0.01, keep_speed = 0 }
spring.slide_z = { stiffness = -20, free = 0 }
[run]
until = 30
)toml";

TEST_CASE("A run that grows without bound ends by body, mode, time and size, and nobody is to blame",
          "[growth][quick]") {
  const auto& [text, what, when] = GENERATE(table<const char*, const char*, const char*>(
      {{kBladeThatLeaves, "has grown without bound: mode a_1 deflects body 'blade' by ", "since t = "},
       {kBoxThatIsPushedOff, "has grown without bound: body 'box' stands ", " m until t = "}}));
  const Model model = parse(text);
  const auto solvers = both_solvers(model);
  const Verdict verdict = compare::verify(model, *solvers[0], *solvers[1], {});
  const std::string said = compare::format_verdict(model, verdict, true);
  INFO(said);
  CHECK(verdict.outcome == Outcome::failed);
  CHECK(verdict.findings.empty());
  CHECK_FALSE(verdict.attribution);
  CHECK(said.find("to blame") == std::string::npos);
  CHECK(verdict.failures.size() >= 2);
  for (const std::string& failure : verdict.failures) {
    CHECK_THAT(failure, Catch::Contains(what) && Catch::Contains(when));
  }
}

}  // namespace
}  // namespace concord::verification
