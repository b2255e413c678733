#include "compare/equilibrium/rests.h"

#include "compare/quantities/align.h"

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

}  // namespace concord::compare
