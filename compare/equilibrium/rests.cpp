#include "compare/equilibrium/rests.h"

#include <fmt/format.h>

#include <optional>

#include "common/error.h"
#include "compare/quantities/align.h"
#include "compare/quantities/motions.h"

namespace concord::compare {

double own_need(const Model& model) { return model.is_flexible() ? kOwnFlexible : kOwnRigid; }

Trajectory one_sample(const State& state, const Evaluation& evaluation) {
  Trajectory trajectory;
  trajectory.samples.push_back({state, evaluation, 0.0});
  return trajectory;
}

Rests find_rests(const Model& model, const Solvers& solvers) {
  Rests rests{{find_equilibrium(model, *solvers[0]), find_equilibrium(model, *solvers[1])}, {}};
  for (const Who who : kBothSolvers) {
    const Equilibrium& one = rests.found[index(who)];
    rests.states[index(who)] = one_sample(one.state, one.evaluation);
  }
  return rests;
}

namespace {

/// Whether a solver that starts in a rest of the other one stays there.
bool stays(const Model& model, Solver& solver, const Trajectory& rest) {
  try {
    const std::optional<State> closed = solver.close(rest.samples[0].state);
    if (!closed) return false;
    const Equilibrium found = find_equilibrium(model, solver, *closed);
    const Trajectory there = one_sample(found.state, found.evaluation);
    return compare_motions(model, {&rest, &there}).digits >= own_need(model);
  } catch (const SolverError&) {
    return false;
  }
}

}  // namespace

void refuse_undetermined_rest(const Model& model, const Solvers& solvers, const Rests& rests) {
  const MotionAgreement agreement = compare_motions(model, {&rests.states[0], &rests.states[1]});
  if (agreement.digits >= own_need(model)) return;
  for (const Who who : kBothSolvers) {
    if (!stays(model, *solvers[index(who)], rests.states[1 - index(who)])) return;
  }
  throw SolverError(fmt::format(
      "statics: the equilibrium is not determined: the solvers come to different rests, and each takes the other "
      "one's for a rest, too; where they part: {}; start nearer to the one that is meant",
      agreement.worst));
}

}  // namespace concord::compare
