#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "closed_forms.h"
#include "common/flexible/beam.h"
#include "compare/audit/places.h"
#include "compare/equilibrium/started_machine.h"
#include "compare/invariance/frames.h"
#include "compare/states/near_frames.h"
#include "judged_machines.h"

/// Bodies whose frames lie far from them, as those of parts that a CAD program exports in one frame.
namespace concord::verification {
namespace {

using compare::NearFrames;

/// A door latch: two links of 12 mm on a hinge and a universal joint, in tilted frames that start in their links, or
/// in that of a vehicle, `away` [m] from them.
std::string latch(const Vec3& away, const std::string& more = "") {
  const auto at = [&](double x, double y, double z) {
    return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", away.x() + x, away.y() + y, away.z() + z);
  };
  return fmt::format(R"toml(format = 1
gravity = [0.4, -0.7, -9.7]
[[body]]
name = "lever"
mass = 0.004
center_of_mass = {}
inertia = [2e-8, 6e-8, 5e-8, 3e-9, -2e-9, 4e-9]
[[body]]
name = "bolt"
mass = 0.002
center_of_mass = {}
inertia = [1e-8, 4e-8, 3.5e-8, -2e-9, 1e-9, 2e-9]
[[joint]]
name = "pin"
type = "revolute"
parent = {{ body = "ground", point = {}, x = [1, 0, 0], z = [0, 0.6, 0.8] }}
child = {{ body = "lever", point = {}, x = [1, 0, 0], z = [0, 0.6, 0.8] }}
start.turn_z = {{ keep = 0.3, keep_speed = 4 }}
[[joint]]
name = "cross"
type = "universal"
parent = {{ body = "lever", point = {}, x = [0, 1, 0], z = [0.28, 0, 0.96] }}
child = {{ body = "bolt", point = {}, x = [0, 1, 0], z = [0.28, 0, 0.96] }}
start.turn_x = {{ keep = 0.2, keep_speed = -6 }}
start.turn_y = {{ keep = -0.1, keep_speed = 3 }}
{}[run]
until = 0.2
)toml",
                     at(0.006, 0.001, -0.0005), at(0.017, -0.001, 0.001), at(0, 0, 0), at(0, 0, 0),
                     at(0.012, 0.0005, 0), at(0.012, 0.0005, 0), more);
}

const Vec3 kVehicle(1.9, -0.8, 0.6);

TEST_CASE("Parts in the frame of a vehicle, or of a country, agree as in their own", "[far][quick]") {
  const NearFrames near(parse(latch(GENERATE(1.0, 1e3, 2e6) * kVehicle)));
  CHECK_THAT(near.note(),
             Catch::StartsWith("computed about mass centres, from which their frames are far away: lever, bolt"));
  const compare::Verdict verdict = judged(near.model(), {});
  INFO(compare::format_verdict(near.model(), verdict, true));
  CHECK(verdict.outcome == compare::Outcome::agree);
}

/// A leaf of 0.15 m on a universal joint, in a frame that is `away` [m] from its first end.
std::string leaf(const Vec3& away, const std::string& support) {
  const std::string first = fmt::format("[{:.17g}, {:.17g}, {:.17g}]", away.x(), away.y(), away.z());
  return fmt::format(R"toml(format = 1
gravity = [0.7, -9.6, 1.5]
[[body]]
name = "leaf"
[body.beam]
length = 0.15
elements = 10
first_end = {}
section = {{ width_y = 0.014, width_z = 0.004 }}
youngs_modulus = 1.1e11
poissons_ratio = 0.3
density = 4400
support = "{}"
modes = {{ bending_xy = [1, 2], bending_xz = [1], torsion = [1] }}
damping_ratio = 0.03
[[joint]]
name = "cross"
type = "universal"
parent = {{ body = "ground", point = [0.3, -0.1, 0.2] }}
child = {{ body = "leaf", node = "first" }}
start.turn_x = {{ keep = 0.4, keep_speed = 1.5 }}
start.turn_y = {{ keep = -0.2, keep_speed = -2 }}
[run]
until = 0.02
)toml",
                     first, support);
}

TEST_CASE("Flexible parts in the frame of a vehicle, or of a plant, agree as in their own", "[far][quick]") {
  const std::string support = GENERATE("cantilever", "simply_supported");
  const NearFrames near(parse(leaf(GENERATE(1.0, 12.0, 900.0) * kVehicle, support)));
  CHECK_THAT(near.note(), Catch::EndsWith("their frames are far away: leaf"));
  const compare::Verdict verdict = judged(near.model(), {});
  INFO(compare::format_verdict(near.model(), verdict, true));
  CHECK(verdict.outcome == compare::Outcome::agree);
}

/// The same leaf with other modes than those of the beam that it states: they are of one that is so much denser.
Model leaf_with_denser_modes(Model model, double density) {
  ModalData& modal = *model.bodies[1].modal;
  const auto stated = modal.beam;
  BeamSpecification denser = *stated;
  denser.density *= density;
  modal = make_beam(denser);
  modal.beam = stated;
  return model;
}

TEST_CASE("A beam far from its frame whose density is 0.1 % wrong is told, in one solver and in both", "[far][quick]") {
  const Model given = parse(leaf(10.0 * kVehicle, "cantilever"));
  const NearFrames near(leaf_with_denser_modes(given, 1.001));
  const compare::Verdict both = judged(near.model(), {});
  INFO(compare::format_verdict(near.model(), both, true));
  CHECK(both.outcome == compare::Outcome::differ);
  for (const compare::SolverSummary& solver : both.solvers) {
    CHECK_THAT(solver.audit_worst, Catch::StartsWith("modal data: leaf"));
  }
  const NearFrames sound(given);
  const auto cartesian_solver = cartesian::make_solver(sound.model());
  const auto relative_solver = relative::make_solver(near.model());
  const compare::Verdict one = compare::verify(sound.model(), *cartesian_solver, *relative_solver, {});
  CHECK(one.outcome == compare::Outcome::differ);
  CHECK_FALSE(one.same_state.passed);
}

TEST_CASE("A beam so far from its frame that its shape is lost is refused by name", "[far][quick]") {
  CHECK_THROWS_WITH(
      NearFrames(parse(leaf(1e6 * kVehicle, "cantilever"))),
      "closed_form.toml:3:1: error: body 'leaf' (flexible): its frame is 2.15e+06 m from its mass centre, "
      "2.9e+07 times what it measures (0.075 m), allowed 1e+06: double precision leaves too few digits of "
      "its shape; describe it in a frame that lies in it or beside it");
}

/// The model with the frame of every body in a tilted place that is so far away from where it was, in all directions.
Model with_far_frames(const Model& model, double distance) {
  std::vector<Pose> frames(model.bodies.size());
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const auto k = static_cast<double>(i);
    frames[i] = {distance * Vec3(std::cos(k), std::sin(2.0 * k), std::cos(3.0 * k + 1.0)).normalized(),
                 compare::exponential_of(Vec3(std::sin(k), std::cos(2.0 * k), std::sin(3.0 * k)))};
  }
  return compare::invariance::with_body_frames(frames).model(model);
}

TEST_CASE("A machine whose frames are far away is the same machine, and its run keeps the audit as it is given",
          "[far]") {
  const std::string name = GENERATE("slider_crank_spatial_flexible", "car_flexible_beam", "loads_on_flexible_bodies",
                                    "flexible_frame_on_springs", "slider_crank_redundant", "springs_in_a_loop",
                                    "tire_test_rig", "ball_on_turntable", "planetary_differential");
  const double distance = GENERATE(20.0, 1000.0);
  DYNAMIC_SECTION(name << ", " << distance << " m") {
    const Model given = with_far_frames(read(name), distance);
    const compare::StartedMachine machine(given, kMakers);
    compare::Verdict verdict = compare::verify(machine.model(), machine.solver(compare::Who::cartesian),
                                               machine.solver(compare::Who::relative), in_short(given, 0.1));
    INFO(compare::format_verdict(given, verdict, true));
    CHECK(verdict.outcome == compare::Outcome::agree);
    CHECK_NOTHROW(machine.back(std::move(verdict.trajectories)));
  }
}

TEST_CASE("Motions about mass centres are led back to the frames that are far away", "[far][quick]") {
  const Vec3 away = GENERATE(1.0, 10.0) * kVehicle;  // the world's origin is moved, too, in the second one
  const NearFrames near(parse(latch(away)));
  const Model own = parse(latch(Vec3::Zero()));
  for (const auto& make : {kMakers.cartesian, kMakers.relative}) {
    RunOptions options;
    options.until = 0.02;
    options.samples = 4;
    const Sample found = near.back(make(near.model())->integrate(options, {})).samples.back();
    const Sample expected = make(own)->integrate(options, {}).samples.back();
    for (std::size_t i = 1; i < 3; ++i) {
      const BodyState& body = expected.state.bodies[i];
      const BodyAcceleration& acceleration = expected.evaluation.bodies[i];
      // What is `away` from the link's own frame moves with the link.
      const Vec3 arm = rotation_of(body.p) * -away;
      CHECK((found.state.bodies[i].r - (away + body.r + arm)).norm() < 1e-9);
      CHECK((found.state.bodies[i].v - (body.v + body.omega.cross(arm))).norm() < 1e-6);
      const Vec3 vdot = acceleration.vdot + acceleration.omegadot.cross(arm) + body.omega.cross(body.omega.cross(arm));
      CHECK((found.evaluation.bodies[i].vdot - vdot).norm() < 1e-7 * vdot.norm());
    }
  }
}

TEST_CASE("Frames that lie in or beside their bodies stay where they are", "[far][quick]") {
  CHECK(NearFrames(parse(latch(Vec3::Zero()))).note().empty());
  for (const char* name : {"car", "slider_crank_flexible", "hanging_chain", "four_bar_with_rod", "double_pendulum_3d"})
    CHECK(NearFrames(read(name)).note().empty());
}

}  // namespace
}  // namespace concord::verification
