#include <catch2/catch.hpp>
#include <functional>

#include "closed_forms.h"
#include "judged_machines.h"

/// Machines for what no shipped model has: large rotations in bushings and bent beams, a modes file, free-free bodies
/// in chains and loops, cut slides and crosses with levers, a wheel over a whole bump, couplings beyond a turn, loops
/// for more than a second. Each agrees and is sensitive: a fault in one solver is a difference, and a fault that both
/// solvers share is refuted by the audit.
namespace concord::verification {
namespace {

using Fault = std::function<void(Model&, double size)>;

/// A machine, the part of its run that the gate runs, and the parameter in which a solver has a fault.
struct Rare {
  std::string name;
  double part;
  std::string what;
  Fault fault;
};

/// Relative to the parameter; lengths: of a metre-sized machine's levers.
constexpr double kFault = 1e-6;

void grow(double& value, double size) { value *= 1.0 + size; }

template <class Element>
Element& first_of(Model& model) {
  for (ForceElement& element : model.elements) {
    if (auto* found = std::get_if<Element>(&element.what)) return *found;
  }
  throw std::logic_error("the machine has no such force element");
}

Attachment& side_of(Model& model, const std::string& joint, Side side) {
  return model.joints[joint_named(model, joint)].sides[index(side)];
}

ModalData& modes_of(Model& model, std::size_t body) { return *model.bodies[body].modal; }

/// A lever of a joint, off every axis.
Fault lever(const std::string& joint, Side side) {
  return [=](Model& model, double size) { side_of(model, joint, side).point_L += size * Vec3(0.18, -0.21, 0.16); };
}

std::vector<Rare> rare_machines() {
  return {
      {"bushing_beyond_a_radian", 0.1, "the bushing's stiffness against turning",
       [](Model& model, double size) { first_of<Bushing>(model).stiffness.bottomRightCorner<3, 3>() *= 1.0 + size; }},
      {"bushing_beyond_a_radian", 0.1, "the bushing's damping against turning",
       [](Model& model, double size) { first_of<Bushing>(model).damping.bottomRightCorner<3, 3>() *= 1.0 + size; }},
      {"bending_beyond_a_radian", 0.05, "how the strip's tip turns with its modes",
       [](Model& model, double size) { side_of(model, "tip", Side::parent).Psi_r_L *= 1.0 + size; }},
      {"modes_file_and_free_free", 0.01, "stiffness of the modes file",
       [](Model& model, double size) { modes_of(model, 1).stiffness *= 1.0 + size; }},
      {"modes_file_and_free_free", 0.01, "how the eye of the modes file turns with its modes",
       [](Model& model, double size) { side_of(model, "eye", Side::parent).Psi_r_L *= 1.0 + size; }},
      {"modes_file_and_free_free", 0.01, "how the free-free bar is displaced where it hangs",
       [](Model& model, double size) { side_of(model, "eye", Side::child).Psi_t_L *= 1.0 + size; }},
      {"modes_file_and_free_free", 0.01, "how the free-free bar is displaced where its spring pulls",
       [](Model& model, double size) { first_of<LineSpring>(model).ends[1].Psi_t_L *= 1.0 + size; }},
      {"free_free_coupler", 0.01, "how the coupler's cut end is displaced",
       [](Model& model, double size) { side_of(model, "C", Side::parent).Psi_t_L *= 1.0 + size; }},
      {"free_free_coupler", 0.01, "how the coupler's first end turns",
       [](Model& model, double size) { side_of(model, "B", Side::child).Psi_r_L *= 1.0 + size; }},
      {"cut_slide_with_lever", 0.1, "the cut slide's lever on the slider", lever("D", Side::child)},
      {"cut_slide_with_lever", 0.1, "the cut slide's place on the ground", lever("D", Side::parent)},
      {"cut_cross_with_lever", 0.1, "the cut cross's lever on the arm", lever("C", Side::parent)},
      {"cut_cross_with_lever", 0.1, "the cut cross's lever", lever("C", Side::child)},
      {"wheel_on_a_bump", 0.5, "the bump's height",
       [](Model& model, double size) {
         Tire& tire = first_of<Tire>(model);
         Road road = *tire.road;
         grow(std::get<HalfSineBump>(road.profile).height, size);
         tire.road = std::make_shared<const Road>(road);
       }},
      {"wheel_on_a_bump", 0.5, "the tire's cornering stiffness",
       [](Model& model, double size) { grow(first_of<Tire>(model).cornering_stiffness, size); }},
      {"couplings_beyond_a_turn", 0.1, "the gears' ratio",
       [](Model& model, double size) { grow(model.couplings[0].terms[1].factor, size); }},
      {"couplings_beyond_a_turn", 0.1, "where the rack stands",
       [](Model& model, double size) { grow(model.couplings[1].offset, size); }},
      {"long_loop", 0.1, "the coupler's far lever", lever("C", Side::parent)},
      {"long_loop", 0.1, "the coupler's mass", [](Model& model, double size) { grow(model.bodies[2].mass, size); }},
  };
}

/// Verdict on `model` where each solver may solve another machine.
compare::Verdict judged(const Model& model, const Model& for_cartesian, const Model& for_relative, double part) {
  const auto cartesian_solver = cartesian::make_solver(for_cartesian);
  const auto relative_solver = relative::make_solver(for_relative);
  compare::VerifyOptions options = in_short(model, part);
  options.states = 12;
  return compare::verify(model, *cartesian_solver, *relative_solver, options);
}

/// Largest rotation of a joint frame of the machine through deformation alone, over a run [rad].
double largest_node_rotation(const Model& model, const Trajectory& trajectory) {
  double largest = 0.0;
  for (const Sample& sample : trajectory.samples) {
    for (const Joint& joint : model.joints) {
      for (const Attachment& side : joint.sides) {
        if (side.Psi_r_L.cols() == 0) continue;
        largest = std::max(largest, (side.Psi_r_L * sample.state.bodies[side.body].a).norm());
      }
    }
  }
  return largest;
}

TEST_CASE("Machines for what no shipped model has agree", "[rare]") {
  const std::vector<Rare> machines = rare_machines();
  for (std::size_t k = 0; k < machines.size(); ++k) {
    if (k > 0 && machines[k - 1].name == machines[k].name) continue;
    const Model model = machine_of("rare", machines[k].name);
    // Loops, couplings and the bump over their whole runs, flexible machines over a part.
    expect_to_agree(model, in_short(model, model.is_flexible() ? 10.0 * machines[k].part : 1.0));
  }
}

TEST_CASE("Machines for what no shipped model has agree over their whole runs", "[rare][nightly]") {
  for (const std::string& name : machines_of("rare")) expect_to_agree(machine_of("rare", name), {});
}

TEST_CASE("A fault of one solver in what no shipped model has is a difference", "[rare]") {
  for (const Rare& rare : rare_machines()) {
    const Model model = machine_of("rare", rare.name);
    Model faulty = model;
    rare.fault(faulty, kFault);
    INFO(rare.name << ": " << rare.what);
    CHECK(judged(model, faulty, model, rare.part).outcome == compare::Outcome::differ);
    CHECK(judged(model, model, faulty, rare.part).outcome == compare::Outcome::differ);
  }
}

TEST_CASE("A fault of both solvers in what no shipped model has is refuted by the audit", "[rare]") {
  for (const Rare& rare : rare_machines()) {
    const Model model = machine_of("rare", rare.name);
    Model faulty = model;
    rare.fault(faulty, 100.0 * kFault);
    const compare::Verdict verdict = judged(model, faulty, faulty, rare.part);
    INFO(rare.name << ": " << rare.what << '\n' << compare::format_verdict(model, verdict, false));
    CHECK(verdict.outcome == compare::Outcome::differ);
    CHECK(verdict.same_state.passed);
    CHECK_FALSE(verdict.audit.passed);
  }
}

TEST_CASE("Machines for what no shipped model has do what they are for", "[rare]") {
  const auto path = [](const std::string& name, double until) {
    const Model model = machine_of("rare", name);
    return run(*relative::make_solver(model), until, 1e-8, 100);
  };
  // The bushing's rotation vector, the strip's tip.
  const Trajectory swings = path("bushing_beyond_a_radian", 0.1);
  CHECK(2.0 * std::acos(std::abs(swings.samples.front().state.q[0](3))) > 1.0);
  CHECK(largest_node_rotation(machine_of("rare", "bending_beyond_a_radian"), path("bending_beyond_a_radian", 0.01)) >
        1.0);
  // The wheel's centre before and behind the bump.
  const Trajectory rolls = path("wheel_on_a_bump", 0.4);
  CHECK(rolls.samples.front().state.bodies[3].r.x() < 0.6);
  CHECK(rolls.samples.back().state.bodies[3].r.x() > 0.6 + 1.1);
  const auto pushed = std::count_if(rolls.samples.begin(), rolls.samples.end(), [](const Sample& sample) {
    return sample.evaluation.elements[0].on_side(Side::child).in_global.force.z() > 0.0;
  });
  CHECK(pushed > 80);
  // Crank and gear.
  const Trajectory turns = path("couplings_beyond_a_turn", 1.6);
  CHECK(turns.samples.front().state.q[0](0) > 2.0 * EIGEN_PI);
  CHECK(turns.samples.back().state.q[0](0) - turns.samples.front().state.q[0](0) > 2.0 * EIGEN_PI);
  CHECK(std::abs(turns.samples.back().state.q[4](0) - turns.samples.front().state.q[4](0)) > 2.0 * EIGEN_PI);
}

}  // namespace
}  // namespace concord::verification
