#include "compare/equilibrium/started_machine.h"

#include <fmt/format.h>

#include "common/error.h"
#include "compare/audit/digits.h"
#include "compare/equilibrium/rests.h"
#include "compare/quantities/motions.h"
#include "compare/states/other_assemblies.h"
#include "compare/states/states.h"

namespace concord::compare {

Model as_it_starts(const Model& model, const SolverMakers& makers, std::string& note) {
  if (!model.run.from_equilibrium) return model;
  Model held = held_at_start(model);
  std::string branch;
  const Solvers solvers = make_solvers_on_one_branch(held, makers, branch);
  const Rests rests = find_rests(held, solvers);
  const auto& [found, states] = rests;
  const MotionAgreement agreement = compare_motions(held, {&states[0], &states[1]});
  if (agreement.digits < own_need(model)) {
    refuse_undetermined_rest(held, solvers, rests);
    throw SolverError(
        fmt::format("the run starts from the equilibrium, but {} differs: {} digits, need {:g}; see "
                    "`concord statics`",
                    agreement.worst, format_digits(agreement.digits), own_need(model)));
  }
  note = fmt::format("starts from the equilibrium, on which both agree to {} digits", format_digits(agreement.digits));
  if (!branch.empty()) note += "; " + branch;
  for (const FreeDirection& direction : found[0].free) {
    note += fmt::format("{} {}",
                        &direction == &found[0].free.front()
                            ? "; without stiffness, as near to their start as balance lets them be:"
                            : ",",
                        direction.name);
  }
  return started_at(model, found[0].state);
}

StartedMachine::StartedMachine(const Model& given, const SolverMakers& makers) : near_(given), notes_(given.notes) {
  std::string start;
  model_ = as_it_starts(near_.model(), makers, start);
  std::string branch;
  solvers_ = make_solvers_on_one_branch(model_, makers, branch);
  for (const std::string& note : {near_.note(), start, branch}) {
    if (!note.empty()) notes_.push_back(note);
  }
}

namespace {

/// The start of the first solver that has one.
std::optional<State> first_start(const StartedMachine& machine) {
  for (const Who who : kBothSolvers) {
    try {
      return machine.solver(who).assemble();
    } catch (const InputError&) {  // the other one may have one
    } catch (const SolverError&) {
    }
  }
  return std::nullopt;
}

void seek_other_poses(const Model& given, const StartedMachine& machine, const SolverMakers& makers, const State& start,
                      StartReport& report) {
  Solver& accepter = machine.solver(Who::cartesian);
  const OtherAssemblies found = find_other_assemblies(machine.model(), start, makers.relative,
                                                      [&](const State& state) { return accepts(accepter, state); });
  for (const State& state : found.states) add_other_pose(given, state, report);
  report.others.guesses = found.guesses;
  report.others.found_by = machine.solver(Who::relative).name();
  report.others.accepted_by = accepter.name();
}

}  // namespace

std::optional<StartReport> start_of(const Model& given, const StartedMachine& machine, const SolverMakers& makers,
                                    SeekPoses seek) {
  const std::optional<State> start = first_start(machine);
  if (!start) return std::nullopt;
  StartReport report = report_start(given, *start);
  if (seek == SeekPoses::of_all || given.joints.size() <= kFewJoints) {
    seek_other_poses(given, machine, makers, *start, report);
  } else {
    report.others.not_sought = !loops_of(given).empty();
  }
  return report;
}

}  // namespace concord::compare
