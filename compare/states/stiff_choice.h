#pragma once

#include <string>

#include "common/solver.h"

/// What becomes of a run that is too stiff for its integrator. Needed by a wheel that rests on its tire: 24 million
/// evaluations in 3 s by the first one, 4395 by the second.
namespace concord::compare {

/// Which integrator made a run, and a note if it is another than the one that was tried first.
struct MadeBy {
  std::string integrator;
  std::string note;
};

/// Integrates by `run.integrator`. If that takes a million evaluations, or would take two at the pace of the first
/// hundred thousand, and is the first that the solver has, the second one, which is for stiff machines, has a fifth of
/// a million: where that is enough, its run counts, else the first goes on to its end. If the first gets nowhere at
/// all, the second may take what it needs. If it may not switch, the message names the second. Throws what the solver
/// throws; where both take too many, TooManyEvaluations with both messages.
Trajectory integrate_or_switch(Solver& solver, const RunOptions& run, bool may_switch, const Progress& progress,
                               MadeBy& made_by);

}  // namespace concord::compare
