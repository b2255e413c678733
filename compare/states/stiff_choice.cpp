#include "compare/states/stiff_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "common/error.h"

namespace concord::compare {

namespace {

/// A run of so many evaluations by the first integrator is doubted: a tire at rest, whose slip settles in microseconds,
/// takes ten times as many by it, and a hundredth by the second.
constexpr long kPatience = 1'000'000;
constexpr long kOfTheSecond = kPatience / 5;

/// No more evaluations than these, and than the caller gives; as soon as it is to be seen that these are not enough,
/// the other integrator is asked.
RunOptions with_at_most(long most, const RunOptions& run) {
  RunOptions own = run;
  own.most_evaluations = std::min(most, run.most_evaluations.value_or(most));
  own.foresees_end = true;
  return own;
}

/// The second integrator's run, if it needs no more than it is given.
std::optional<Trajectory> short_run(Solver& solver, const RunOptions& stiff, const Progress& progress) {
  try {
    return solver.integrate(with_at_most(kOfTheSecond, stiff), progress);
  } catch (const SolverError&) {  // the first one is asked again
    return std::nullopt;
  }
}

std::string note_of(const Solver& solver, const std::string& first, const std::string& second, const std::string& why) {
  return fmt::format("{} runs by {}, which is for stiff machines, because {} took too long: {}", solver.name(), second,
                     first, why);
}

/// The first integrator gets nowhere.
Trajectory integrate_stiff(Solver& solver, const RunOptions& stiff, const std::string& first,
                           const Progress& progress) {
  try {
    return solver.integrate(stiff, progress);
  } catch (const TooManyEvaluations& error) {
    throw TooManyEvaluations(fmt::format("{}; then by {}: {}", first, stiff.integrator, error.what()));
  } catch (const SingularPose& error) {
    throw SingularPose(fmt::format("{}; then by {}: {}", first, stiff.integrator, error.what()));
  } catch (const SolverError& error) {
    throw SolverError(fmt::format("{}; then by {}: {}", first, stiff.integrator, error.what()));
  }
}

}  // namespace

Trajectory integrate_or_switch(Solver& solver, const RunOptions& run, bool may_switch, const Progress& progress,
                               MadeBy& made_by) {
  made_by = {run.integrator, {}};
  const std::vector<std::string> known = solver.integrators();
  const bool has_other = known.size() > 1 && run.integrator == known.front();
  RunOptions stiff = run;
  if (has_other) stiff.integrator = known[1];
  const auto switch_because = [&](const std::string& why) {
    made_by = {stiff.integrator, note_of(solver, run.integrator, stiff.integrator, why)};
  };
  std::string first;
  if (has_other && may_switch) {
    try {
      return solver.integrate(with_at_most(kPatience, run), progress);
    } catch (const EvaluationsSpent& error) {
      if (auto trajectory = short_run(solver, stiff, progress)) {
        switch_because(error.what());
        return std::move(*trajectory);
      }
    } catch (const TooManyEvaluations& error) {
      first = error.what();
    }
  }
  if (first.empty()) {
    try {
      return solver.integrate(run, progress);
    } catch (const TooManyEvaluations& error) {
      if (!has_other) throw;
      if (!may_switch) throw TooManyEvaluations(fmt::format("{}; {} is for stiff machines", error.what(), known[1]));
      first = error.what();
    }
  }
  Trajectory trajectory = integrate_stiff(solver, stiff, first, progress);
  switch_because(first);
  return trajectory;
}

}  // namespace concord::compare
