#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "compare/audit/energy.h"
#include "judged_machines.h"

/// Machines whose loops leave a flexible body's modes no freedom of their own.
namespace concord::verification {
namespace {

/// Two arms on tilted hinges, tied by a beam that is welded to both: every turn of one against the other bends it.
constexpr const char* kTiedArms = R"(format = 1
gravity = [0.3, -9.7, 1.1]
[[body]]
name = "left_arm"
mass = 3.1
center_of_mass = [0.21, 0.02, -0.01]
inertia = [0.02, 0.11, 0.1]
[[body]]
name = "right_arm"
mass = 2.7
center_of_mass = [0.18, -0.03, 0.02]
inertia = [0.03, 0.09, 0.08]
[[joint]]
name = "left_hinge"
type = "revolute"
both = { z = [0.1, 1, 0.05], x = [1, -0.1, 0] }
parent = { body = "ground", point = [0, 0.5, 0] }
child = "left_arm"
start.turn_z = { guess = 0, guess_speed = 0 }
[[joint]]
name = "right_hinge"
type = "revolute"
both = { z = [0.1, 1, 0.05], x = [1, -0.1, 0] }
parent = { body = "ground", point = [0, -0.5, 0] }
child = "right_arm"
start.turn_z = { guess = 0, guess_speed = 0 }
[[body]]
name = "beam"
[body.beam]
first_end = [0.03, 0.5, 0]
x = [0, -1, 0]
z = [0, 0, 1]
length = 1.0
elements = 8
section = { area = 4e-4, second_moment_y = 2.5e-8, second_moment_z = 4.0e-8, torsion_constant = 5e-9 }
youngs_modulus = 2.1e11
shear_modulus = 79.3e9
density = 7850
support = "craig_bampton"
modes = { bending_xz = [1] }
static_modes = { bending_xy = [1, 2], bending_xz = [1, 2], torsion = [1], axial = [1] }
damping_ratio = 0.02
[[joint]]
name = "left_weld"
type = "weld"
parent = { body = "left_arm", point = [0.03, 0, 0] }
child = { body = "beam", node = "first" }
[[joint]]
name = "right_weld"
type = "weld"
parent = { body = "right_arm", point = [0.03, 0, 0] }
child = { body = "beam", node = "last" }
)";

/// The state with one arm turned about its hinge's place, and everything else as it was.
State turned_arm(const State& state, double angle) {
  State turned = state;
  BodyState& arm = turned.bodies[1];
  const Eigen::Quaterniond before(arm.p(0), arm.p(1), arm.p(2), arm.p(3));
  const Eigen::Quaterniond after = Eigen::AngleAxisd(angle, Vec3(0.1, 1.0, 0.05).normalized()) * before;
  arm.p << after.w(), after.x(), after.y(), after.z();
  arm.omega += angle * Vec3(0.3, 2.0, 0.1);
  return turned;
}

TEST_CASE("A beam that is held at both ends can be closed, and the other solver takes the state as closed") {
  const Model model = parse_model(kTiedArms, "tied_arms.toml");
  for (const bool by_cartesian : {true, false}) {
    INFO("closed by " << (by_cartesian ? "cartesian" : "relative"));
    const auto closing = by_cartesian ? cartesian::make_solver(model) : relative::make_solver(model);
    const auto other = by_cartesian ? relative::make_solver(model) : cartesian::make_solver(model);
    const State start = closing->assemble();
    const std::optional<State> closed = closing->close(turned_arm(start, 0.02));
    REQUIRE(closed);
    // Cartesian weighs modes by their stiffness: it turns the arms rather than bend the beam.
    if (!by_cartesian) CHECK((closed->bodies[3].a - start.bodies[3].a).norm() > 1e-4);
    const Evaluation own = closing->evaluate(*closed);
    const Evaluation others = other->evaluate(*closed);
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      const Vec3 force = own.joints[k].reaction_on(Side::child).in_global.force;
      CHECK((force - others.joints[k].reaction_on(Side::child).in_global.force).norm() < 1e-9 * force.norm());
    }
  }
}

TEST_CASE("Closing by a solver that has not run before bends the beam as well") {
  const Model model = parse_model(kTiedArms, "tied_arms.toml");
  const State start = cartesian::make_solver(model)->assemble();
  for (const auto& fresh : {cartesian::make_solver(model), relative::make_solver(model)}) {
    INFO(fresh->name());
    CHECK(fresh->close(turned_arm(start, 0.02)));
  }
}

TEST_CASE("Closing leaves alone the modes of a coupler that its pins do not bend") {
  const Model model = read_model(std::filesystem::path(CONCORD_DATA) / "models" / "slider_crank_spatial_flexible.toml");
  for (const auto& solver : {cartesian::make_solver(model), relative::make_solver(model)}) {
    INFO(solver->name());
    State guess = solver->assemble();
    std::size_t coupler = 1;
    while (guess.bodies[coupler].a.size() == 0) ++coupler;
    guess.bodies[coupler].a.array() += 1e-4;
    guess.bodies[coupler].adot.array() -= 2e-3;
    const std::optional<State> closed = solver->close(guess);
    REQUIRE(closed);
    CHECK(closed->bodies[coupler].a == guess.bodies[coupler].a);
    CHECK(closed->bodies[coupler].adot == guess.bodies[coupler].adot);
  }
}

TEST_CASE(
    "A loop that must bend its beams where its joints are stretched keeps its energy, however many steps it takes") {
  const Model model = machine_of("loops", "loop_that_stretches");
  for (const auto& make : {cartesian::make_solver, relative::make_solver}) {
    const auto solver = make(model);
    for (const int samples : {30, 1000}) {
      INFO(solver->name() << ", " << samples << " samples");
      const Trajectory run = solver->integrate({model.run.until, 1e-12, samples, ""}, {});
      CHECK(compare::audit_energy(model, run).relative() < 1e-12);
    }
  }
}

/// A micromachine, driven: beams of half a millimetre that vibrate by picometres.
constexpr const char* kVibratingFourBar = R"(format = 1
gravity = [0.0, -9.81, 0.0]
[[body]]
name = "crank"
mass = 6.480000000000001e-10
inertia = [2.9160000000000005e-19, 9.234000000000002e-19, 9.234000000000002e-19]
center_of_mass = [6e-05, 0.0, 0.0]
[[body]]
name = "coupler"
[body.beam]
length = 0.00045000000000000004
elements = 20
youngs_modulus = 160000000000.0
poissons_ratio = 0.3
density = 2700.0
section = { width_y=2e-05, width_z=0.0001 }
support = "simply_supported"
modes = { bending_xy=[1,2], bending_xz=[1] }
damping_ratio = 0.01
[[body]]
name = "rocker"
[body.beam]
length = 0.0004
elements = 20
youngs_modulus = 160000000000.0
poissons_ratio = 0.3
density = 2700.0
section = { width_y=2e-05, width_z=0.0001 }
support = "cantilever"
modes = { bending_xy=[1,2], torsion=[1] }
damping_ratio = 0.01
[[joint]]
name = "A"
type = "revolute"
parent = "ground"
child = { body = "crank", point = [0.0, 0.0, 0.0] }
drive.turn_z={law="polynomial",coefficients=[0.6,10,15]}
[[joint]]
name = "B"
type = "revolute"
parent = { body = "crank", point = [0.00012, 0.0, 0.0] }
child = { body = "coupler", node = "first" }
start.turn_z={guess=0.1993730354689348}
[[joint]]
name = "C"
type = "spherical"
parent = { body = "coupler", node = "last" }
child = { body = "rocker", node = "last" }
start.ball={guess={axis=[0,0,1],angle=0.9912888756200258}}
[[joint]]
name = "D"
type = "revolute"
parent = { body = "ground", point = [0.0005, 0.0, 0.0] }
child = { body = "rocker", node = "first" }
start.turn_z={guess=1.7906619110889606}
[run]
until = 0.0003
)";

/// Round-off of where the loop closes lets the stiffer modes vibrate by 1e-6 of what they do, faster in the loop than
/// each would alone.
TEST_CASE("Vibrations that round-off of a loop's places makes are no difference", "[modes]") {
  const compare::Verdict verdict = judged(parse(kVibratingFourBar), {});
  INFO(compare::format_verdict(parse(kVibratingFourBar), verdict, false));
  CHECK(verdict.outcome == compare::Outcome::agree);
  // In so stiff a loop the same round-off makes forces of the size of those in the motion, and the verdict says so.
  CHECK_FALSE(verdict.same_run.digits);
  CHECK_THAT(verdict.notes, Catch::VectorContains(std::string(
                                "no reaction of the runs is judged: what they leave open of places makes forces of "
                                "more than 1e-06 of those in this motion, as where a loop holds stiff bodies; the "
                                "states are judged")));
}

}  // namespace
}  // namespace concord::verification
