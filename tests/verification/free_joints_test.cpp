#include <catch2/catch.hpp>
#include <string>

#include "judged_machines.h"

/// Machines in which no joint constrains anything: forces on joint speeds are all that there is to judge.
namespace concord::verification {
namespace {

/// A block on a free joint; `on_z` is what is said of its motion along z.
Model held_block(const std::string& on_z) {
  return parse_model(R"(format = 1
name = "held_block"
gravity = [0.3, -9.7, 0.8]

[[body]]
name = "block"
mass = 2.7
center_of_mass = [0.06, -0.11, 0.21]
inertia = [0.31, 0.27, 0.42, 0.02, -0.03, 0.05]

[[joint]]
name = "hold"
type = "free"
parent = { body = "ground", point = [0.2, -0.4, 0.1], euler_parameters = [0.8, 0.36, -0.48, 0.0] }
child = { body = "block", point = [-0.07, 0.12, 0.3], euler_parameters = [0.6, 0.0, 0.48, 0.64] }
start.slide_x = { keep = 0.15, keep_speed = 0.4 }
start.slide_y = { keep = -0.1, keep_speed = -0.7 }
start.ball = { keep = { euler_parameters = [0.8, 0.0, 0.6, 0.0] }, keep_speed = [0.9, -1.3, 0.5] }
)" + on_z + R"(
[run]
until = 0.2
)",
                     "held_block.toml");
}

compare::Verdict verdict_on(const std::string& on_z) {
  const Model model = held_block(on_z);
  return judged(model, in_short(model, 0.5));
}

constexpr const char* kFree = "start.slide_z = { keep = 0.05, keep_speed = 0.2 }\n";

}  // namespace

TEST_CASE("Where no joint constrains anything, the forces on joint speeds are judged", "[quick][free]") {
  const std::string spring = "spring.slide_z = { stiffness = 140.0, damping = 2.0, free = 0.02 }\n";
  const std::string driver = "drive.slide_z = { law = \"smooth_step\", t0 = 0.0, t1 = 0.5, from = 0.05, to = 0.11 }\n";
  for (const std::string& on_z : {kFree + spring, driver}) {
    const compare::Verdict verdict = verdict_on(on_z);
    INFO(on_z);
    CHECK(verdict.outcome == compare::Outcome::agree);
    CHECK(verdict.judged == 0);
    CHECK(verdict.same_state.digits.value_or(0.0) > 12.0);
    CHECK(verdict.refined.passed);
  }
}

TEST_CASE("A body that nothing but gravity acts on is no verdict", "[quick][free]") {
  const compare::Verdict verdict = verdict_on(kFree);
  CHECK(verdict.outcome == compare::Outcome::failed);
}

}  // namespace concord::verification
