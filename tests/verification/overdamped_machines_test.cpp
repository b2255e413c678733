#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "judged_machines.h"

/// Machines whose dampers are so strong that they creep to rest: the explicit integrators give them up to those for
/// stiff machines.
namespace concord::verification {
namespace {

/// An arm of 0.3 kg on a hinge with a spring of 5e4 N m/rad.
std::string damped_hinge(const std::string& axis, double speed, double damping) {
  return fmt::format(R"(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "arm"
mass = 0.3
inertia = [0.002, 0.0025, 0.003]
center_of_mass = [0.08, 0, 0.01]
[[joint]]
name = "hinge"
type = "revolute"
both = {{ axis = {}, angle = "-70 deg" }}
parent = "ground"
child = "arm"
start.turn_z = {{ keep = 0, keep_speed = {} }}
spring.turn_z = {{ stiffness = 5e4, damping = {} }}
)",
                     axis, speed, damping);
}

/// A block on a vertical slide that sinks by `weight / 2e7` with a time constant of 0.02 s.
const std::string kSinkingBlock = R"(format = 1
gravity = [0.0, 0.0, -9.81]
[[body]]
name = "block"
mass = 1.4
inertia = [0.1, 0.12, 0.15]
[[joint]]
name = "guide"
type = "translational"
parent = "ground"
child = "block"
start.slide_z = { keep = 0.0, keep_speed = 0.0 }
spring.slide_z = { stiffness = 2e7, damping = 4e5 }
)";

/// An engine on a light bracket, between bushings with strong dampers, that is let go and settles.
const std::string kEngineOnABracket = R"(format = 1
gravity = [0.0, 0.0, -9.81]
[[body]]
name = "engine"
mass = 90
inertia = [3.1, 4.2, 5.3]
[[body]]
name = "bracket"
mass = 0.06
inertia = [0.0001, 0.00012, 0.00014]
[[joint]]
name = "of engine"
type = "free"
parent = "ground"
child = "engine"
start.slide_x = { keep = 0, keep_speed = 0 }
start.slide_y = { keep = 0, keep_speed = 0 }
start.slide_z = { keep = 0.1, keep_speed = 0 }
start.ball = { keep = { axis = [0, 0, 1], angle = 0.0 }, keep_speed = [0.0, 0.0, 0.0] }
[[joint]]
name = "of bracket"
type = "free"
parent = "ground"
child = "bracket"
start.slide_x = { keep = 0, keep_speed = 0 }
start.slide_y = { keep = 0, keep_speed = 0 }
start.slide_z = { keep = 0, keep_speed = 0 }
start.ball = { keep = { axis = [0, 0, 1], angle = 0.0 }, keep_speed = [0.0, 0.0, 0.0] }
[[bushing]]
name = "below"
parent = "ground"
child = "bracket"
stiffness = [1.1e7, 1.1e7, 1.1e7, 1e4, 1e4, 1e4]
damping = [1e4, 1e4, 1e4, 10, 10, 10]
[[bushing]]
name = "above"
parent = { body = "bracket", point = [0.0, 0.0, 0.05] }
child = { body = "engine", point = [0.0, 0.0, -0.05] }
stiffness = [1e6, 1e6, 1e6, 1e4, 1e4, 1e4]
damping = [3e3, 3e3, 3e3, 30, 30, 30]
)";

compare::VerifyOptions by_stiff_integrators() {
  compare::VerifyOptions options;
  options.integrators = {"ida", "dirk"};
  return options;
}

}  // namespace

TEST_CASE("An overdamped hinge that settles from rest agrees and keeps its energy", "[quick]") {
  expect_to_agree(parse(damped_hinge("[1, 0, 0]", 0.0, 6e3)), by_stiff_integrators());
}

TEST_CASE("An overdamped hinge about a tilted axis, let go with a speed, agrees", "[quick]") {
  expect_to_agree(parse(damped_hinge("[2, -0.5, 0]", 0.3, 2e3)), by_stiff_integrators());
}

TEST_CASE("A block that sinks on a strong damper agrees", "[quick]") {
  expect_to_agree(parse(kSinkingBlock), by_stiff_integrators());
}

TEST_CASE("Both integrators for stiff machines follow a sinking block to its rest in few evaluations", "[quick]") {
  const Model model = parse(kSinkingBlock);
  const double rest = -1.4 * 9.81 / 2e7;
  const std::array<std::string, 2> names{"ida", "dirk"};
  std::size_t who = 0;
  for (const auto& solver : both_solvers(model)) {
    for (const double rtol : {1e-9, 1e-11, 1e-13}) {
      const Trajectory trajectory = run(*solver, 2.0, rtol, 200, names[who]);
      INFO(solver->name() << ", rtol " << rtol << ", " << trajectory.statistics.evaluations << " evaluations");
      const BodyState& end = trajectory.samples.back().state.bodies[1];
      CHECK(std::abs(end.r.z() - rest) < 1e-9 * std::abs(rest));
      CHECK(std::abs(end.v.z()) < 1e-12);
      CHECK(trajectory.statistics.evaluations < 20000);
    }
    ++who;
  }
}

TEST_CASE("What the implicit integrator of relative leaves falls with the tolerance until round-off is left",
          "[quick]") {
  const Model model = parse(kEngineOnABracket);
  const auto solver = relative::make_solver(model);
  const auto heights = [&](double rtol) {
    const Trajectory trajectory = run(*solver, 2.0, rtol, 300, "dirk");
    VecX z(static_cast<Eigen::Index>(trajectory.samples.size()));
    for (Eigen::Index k = 0; k < z.size(); ++k)
      z(k) = trajectory.samples[static_cast<std::size_t>(k)].state.bodies[1].r.z();
    return z;
  };
  const VecX reference = heights(2e-14);
  for (const double rtol : {1e-9, 1e-10, 1e-11, 1e-12, 3e-13, 2e-13, 1e-13, 7e-14, 5e-14, 3e-14}) {
    const double error = (heights(rtol) - reference).lpNorm<Eigen::Infinity>();
    INFO("rtol " << rtol << ", error " << error << " m");
    CHECK(error < 0.1 * rtol + 1e-14);
  }
}

}  // namespace concord::verification
