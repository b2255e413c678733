#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>

#include "cartesian/solver.h"
#include "common/reading/model_file.h"
#include "compare/audit/digits.h"
#include "compare/audit/places.h"
#include "compare/invariance/moves.h"
#include "compare/invariance/sides.h"
#include "compare/invariance/units.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/align.h"
#include "compare/quantities/motions.h"
#include "compare/states/states.h"
#include "relative/solver.h"

/// A machine does not know in which words it is told: whatever frames, sides, order, modes or units its file chooses,
/// each solver must find the same physical motion and reactions.
namespace concord::verification {
namespace {

using namespace compare::invariance;
using compare::rotation_of;
using Uniqueness = std::vector<JointUniqueness>;

constexpr double kNeededDigits = 10.0;
constexpr int kRunStates = 5;
constexpr int kShakenStates = 5;

using MakeSolver = std::unique_ptr<Solver> (*)(const Model&);

struct Maker {
  const char* name;
  MakeSolver make;
};
const std::vector<Maker> kSolvers{{"cartesian", cartesian::make_solver}, {"relative", relative::make_solver}};

const std::vector<std::string> kCranks{"slider_crank_spatial_rigid", "slider_crank_spatial_flexible",
                                       "slider_crank_redundant"};
const std::vector<std::string> kMachines{"slider_crank_spatial_rigid", "slider_crank_spatial_flexible",
                                         "slider_crank_redundant", "double_pendulum_3d"};

Model machine(const std::string& name) { return read_model(std::string(CONCORD_DATA) + "/models/" + name + ".toml"); }

/// States of a short run, its start among them, and closed states around them where every body has been moved, turned
/// and set in motion and every mode drawn anew within what the run has seen.
std::vector<State> generic_states(const Model& model, Solver& solver) {
  RunOptions options;
  options.until = model.is_flexible() ? 0.02 : 0.3;
  options.rtol = 1e-8;
  options.samples = kRunStates - 1;
  std::vector<compare::OwnedState> run;
  for (const Sample& sample : solver.integrate(options, {}).samples) run.push_back({sample.state, {}});
  std::vector<State> states;
  for (const compare::OwnedState& owned : run) states.push_back(owned.state);

  compare::StatePerturbation perturbation(model, run, compare::kSeed);
  for (int attempt = 0; attempt < 10 * kShakenStates && states.size() < kRunStates + kShakenStates; ++attempt) {
    const State& base = run[attempt % kRunStates].state;
    if (const std::optional<State> closed = solver.close(perturbation.perturb(base, 1.0))) states.push_back(*closed);
  }
  REQUIRE(states.size() == kRunStates + kShakenStates);
  return states;
}

/// Digits of the agreement of two motions: places relative to the machine's length, velocities to the largest.
double digits_between(const Model& model, const State& one, const State& other) {
  double largest_speed = 0.0;
  double largest_spin = 0.0;
  for (const BodyState& body : one.bodies) {
    largest_speed = std::max(largest_speed, body.v.norm());
    largest_spin = std::max(largest_spin, body.omega.norm());
  }
  double worst = 0.0;
  for (std::size_t i = 1; i < one.bodies.size(); ++i) {
    const BodyState& a = one.bodies[i];
    const BodyState& b = other.bodies[i];
    worst = std::max({worst, (a.r - b.r).norm() / model.length_scale(),
                      compare::angle_between(rotation_of(a.p), rotation_of(b.p)), (a.v - b.v).norm() / largest_speed,
                      (a.omega - b.omega).norm() / largest_spin});
    if (a.a.size() > 0) worst = std::max({worst, (a.a - b.a).norm(), (a.adot - b.adot).norm()});
  }
  return compare::matching_digits(worst, 1.0);
}

/// Which rows of the layout are physical: of a wrench with components that redundant constraints leave open, only the
/// unique ones in joint axes.
bool is_unique(const compare::Quantity& quantity, const Uniqueness& flags) {
  using compare::Kind;
  if (quantity.kind == Kind::acceleration || quantity.kind == Kind::body_sum || quantity.kind == Kind::tau) {
    return true;
  }
  const auto& unique = flags[quantity.owner].unique[index(quantity.side)];
  if (quantity.kind != Kind::reaction_global) return unique[quantity.component];
  return std::find(unique.begin(), unique.end(), false) == unique.end();
}

struct Worst {
  double digits = compare::kMostDigits;
  std::string where = "everything";
};

/// The worst agreement over all reactions, total wrenches, sums on bodies and accelerations that are unique.
Worst worst_of(const compare::QuantityLayout& layout, const compare::Series& series, const Uniqueness& flags) {
  const std::vector<compare::Measured> measured = compare::measure(layout, series);
  Worst worst;
  for (std::size_t row = 0; row < measured.size(); ++row) {
    const compare::Quantity& quantity = layout.quantities()[row];
    if (!is_unique(quantity, flags) || measured[row].digits >= worst.digits) continue;
    worst = {measured[row].digits,
             fmt::format("{}, {}, state {}: {} and {}, scale {}", describe_owner(layout.model(), quantity),
                         describe_component(quantity), measured[row].worst, measured[row].values[0],
                         measured[row].values[1], measured[row].scale)};
  }
  return worst;
}

/// Set CONCORD_PRINT_DIGITS to see the agreement of every case.
void tell(const std::string& what, double motion, const Worst& worst) {
  if (std::getenv("CONCORD_PRINT_DIGITS") == nullptr) return;
  std::cout << fmt::format("{}: start {}, wrenches and accelerations {} digits ({})\n", what,
                           compare::format_digits(motion), compare::format_digits(worst.digits), worst.where);
}

/// One solver, one machine, told as it stands and told anew.
void expect_same_physics(const Maker& solver, const std::string& name, const Model& model, const Change& change,
                         const std::string& what) {
  const std::string title = fmt::format("{}, {}, {}", what, name, solver.name);
  INFO(title);
  const Model again = change.model(model);
  const std::unique_ptr<Solver> first = solver.make(model);
  const std::unique_ptr<Solver> second = solver.make(again);
  const std::vector<State> states = generic_states(model, *first);

  const double motion = digits_between(again, change.state(states.front()), second->assemble());
  CHECK(motion >= kNeededDigits);

  const Uniqueness flags = first->rank(states.front()).joints;
  const Uniqueness flags_again = change.report(second->rank(change.state(states.front()))).joints;
  std::vector<compare::SharedState> both;
  for (const State& state : states) {
    both.push_back({state, {first->evaluate(state), change.evaluation(state, second->evaluate(change.state(state)))}});
  }
  const compare::QuantityLayout layout(model);
  const Worst worst = worst_of(layout, compare::align(layout, both), flags);
  tell(title, motion, worst);
  INFO(worst.where);
  CHECK(worst.digits >= kNeededDigits);
  for (std::size_t k = 0; k < flags.size(); ++k) CHECK(flags[k].unique == flags_again[k].unique);
}

Change sides_swapped(const Model& model) {
  const PartialChange swapped = swapped_sides(model, std::nullopt);
  REQUIRE(swapped.left.empty());
  return swapped.change;
}

/// Calls `make` for the change of each machine and looks at both solvers.
template <class MakeChange>
void for_all(const std::vector<std::string>& machines, const std::string& what, const MakeChange& make) {
  for (const std::string& name : machines) {
    const Model model = machine(name);
    const Change change = make(model);
    for (const Maker& solver : kSolvers) expect_same_physics(solver, name, model, change, what);
  }
}

TEST_CASE("Whichever joint of a loop is cut, all reactions are the same, its own among them", "[invariance]") {
  for (const std::string& name : kCranks) {
    const Model model = machine(name);
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      const Change change = cut_at(k);
      const std::string& joint = model.joints[k].name;
      CHECK(relative::make_solver(change.model(model))->cut_joints() == std::vector{joint});
      for (const Maker& solver : kSolvers) expect_same_physics(solver, name, model, change, "cut at " + joint);
    }
  }
}

TEST_CASE("Parent and child of every joint may change places: the wrench on each body stays", "[invariance]") {
  for_all(kMachines, "sides swapped", [](const Model& model) { return sides_swapped(model); });
}

TEST_CASE("Sides may be swapped and any joint cut at once: the tree then runs against the joints", "[invariance]") {
  for (const std::string& name : kCranks) {
    const Model model = machine(name);
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      expect_same_physics(kSolvers[1], name, model, sides_swapped(model) | cut_at(k),
                          "sides swapped, cut at " + model.joints[k].name);
    }
  }
}

TEST_CASE("The frame of a body may lie anywhere in it", "[invariance]") {
  for_all(kMachines, "body frames moved", [](const Model& model) { return moved_frames(model, 101); });
}

TEST_CASE("The world may be turned and moved together with gravity and ground", "[invariance]") {
  for_all(kMachines, "world turned", [](const Model& model) { return moved_world(model, 103); });
}

TEST_CASE("Bodies and joints may stand in any order in the file", "[invariance]") {
  for_all(kMachines, "order shuffled", [](const Model& model) { return shuffled(model, 107); });
}

TEST_CASE("The modes of a flexible body may be combined anew", "[invariance]") {
  for_all({"slider_crank_spatial_flexible"}, "modes recombined",
          [](const Model& model) { return recombined(model, 109); });
}

TEST_CASE("A machine may be told in other units of length, mass and time", "[invariance]") {
  const Units in_mm_and_t{1e3, 1e-3, 1.0};
  const Units in_km_and_mg{1e-3, 1e6, 1.0};
  const Units in_inch_pound_ms{39.37, 2.2046, 1e3};
  for (const Units& units : {in_mm_and_t, in_km_and_mg, in_inch_pound_ms}) {
    for_all(kMachines, fmt::format("lengths x {}, masses x {}, times x {}", units.length, units.mass, units.time),
            [&](const Model& model) { return in_units(model, units); });
  }
}

/// Everything that a file may say otherwise, one after the other.
Change all_at_once(const Model& model, std::uint64_t seed) {
  return sides_swapped(model) | moved_frames(model, seed) | moved_world(model, seed + 1) | recombined(model, seed + 2) |
         in_units(model, {3.28, 0.0685, 1.0}) | shuffled(model, seed + 3);
}

TEST_CASE("All of it may change at once", "[invariance]") {
  for_all(kMachines, "all at once", [](const Model& model) { return all_at_once(model, 113); });
}

TEST_CASE("A whole run is the same, whatever the words", "[invariance][nightly]") {
  constexpr double kNeededOfARun = 6.0;
  for (const std::string& name : kMachines) {
    const Model model = machine(name);
    const Change change = all_at_once(model, 127);
    const Model again = change.model(model);
    RunOptions options;
    options.until = model.is_flexible() ? 0.1 : 1.0;
    options.rtol = model.is_flexible() ? 1e-9 : 1e-11;
    options.samples = 50;
    for (const Maker& solver : kSolvers) {
      INFO(name << ", " << solver.name);
      const Trajectory first = solver.make(model)->integrate(options, {});
      const Trajectory second = solver.make(again)->integrate(options, {});
      std::vector<compare::SharedState> both;
      for (std::size_t k = 0; k < first.samples.size(); ++k) {
        const State& state = first.samples[k].state;
        both.push_back({state, {first.samples[k].evaluation, change.evaluation(state, second.samples[k].evaluation)}});
      }
      const Uniqueness flags = solver.make(model)->rank(first.samples.front().state).joints;
      const compare::QuantityLayout layout(model);
      const Worst worst = worst_of(layout, compare::align(layout, both), flags);
      tell(fmt::format("run, {}, {}", name, solver.name), compare::kMostDigits, worst);
      INFO(worst.where);
      CHECK(worst.digits >= kNeededOfARun);
    }
  }
}

}  // namespace
}  // namespace concord::verification
