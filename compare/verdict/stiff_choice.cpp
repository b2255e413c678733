#include "compare/verdict/stiff_choice.h"

#include <fmt/format.h>

#include "common/error.h"

namespace concord::compare {

Trajectory integrate_or_switch(Solver& solver, const RunOptions& run, bool may_switch, const Progress& progress,
                               MadeBy& made_by) {
  made_by = {run.integrator, {}};
  const std::vector<std::string> known = solver.integrators();
  const bool has_other = known.size() > 1 && run.integrator == known.front();
  std::string first;
  try {
    return solver.integrate(run, progress);
  } catch (const TooManyEvaluations& error) {
    if (!has_other) throw;
    if (!may_switch) throw TooManyEvaluations(fmt::format("{}; {} is for stiff machines", error.what(), known[1]));
    first = error.what();
  }
  RunOptions stiff = run;
  stiff.integrator = known[1];
  try {
    Trajectory trajectory = solver.integrate(stiff, progress);
    made_by = {stiff.integrator, fmt::format("{} runs by {}, which is for stiff machines, because {} took too long: {}",
                                             solver.name(), stiff.integrator, run.integrator, first)};
    return trajectory;
  } catch (const TooManyEvaluations& error) {
    throw TooManyEvaluations(fmt::format("{}; then by {}: {}", first, stiff.integrator, error.what()));
  } catch (const SingularPose& error) {
    throw SingularPose(fmt::format("{}; then by {}: {}", first, stiff.integrator, error.what()));
  } catch (const SolverError& error) {
    throw SolverError(fmt::format("{}; then by {}: {}", first, stiff.integrator, error.what()));
  }
}

}  // namespace concord::compare
