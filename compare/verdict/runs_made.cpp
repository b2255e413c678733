#include <fmt/format.h>

#include <future>
#include <memory>
#include <string>
#include <utility>

#include "common/error.h"
#include "compare/states/stiff_choice.h"
#include "compare/verdict/refinement.h"
#include "compare/verdict/runs.h"

/// How the runs of both solvers are made: side by side, as many at a time as there are processors.
namespace concord::compare {

RunPair RunChecks::integrate(const RunOptions& run, Check check) {
  return run_both(run, name_of(check), verdict_.failures, may_switch_);
}

const std::string& RunChecks::integrator_of(Who who) const {
  const std::string& later = goes_on_by_[index(who)];
  return later.empty() ? verdict_.solvers[index(who)].integrator : later;
}

/// Begins the runs of all solvers but those that rest.
void RunChecks::start(Running& running, const char* what, const std::array<bool, 2>& may_switch,
                      const std::array<bool, 2>& rests) {
  for (const Who who : kBothSolvers) {
    if (rests[index(who)]) continue;
    RunOptions own = running.run;
    own.integrator = integrator_of(who);
    running.trajectories[index(who)] =
        std::async(std::launch::async, [this, own, what, who, &made_by = running.made_by[index(who)],
                                        may = may_switch[index(who)], place = turns_.take()] {
          const Turns::Held turn(turns_, place);
          const auto tell = [&](double t) { progress_.advance(what, who, t / own.until); };
          return integrate_or_switch(*solvers_[index(who)], own, may, tell, made_by);
        });
  }
}

RunPair RunChecks::finish(Running& running, const char* what, std::vector<std::string>& failures) {
  RunPair pair{running.run, {}, {}, {}, {}};
  for (const Who who : kBothSolvers) {
    if (!running.trajectories[index(who)].valid()) continue;
    try {
      pair.trajectories[index(who)] = running.trajectories[index(who)].get();
    } catch (const SolverError& error) {
      failures.push_back(fmt::format("{}: {}", what, error.what()));
      ahead_.reset();
    }
  }
  for (const Who who : kBothSolvers) {
    const MadeBy& made_by = running.made_by[index(who)];
    pair.integrators[index(who)] = made_by.integrator;
    may_switch_[index(who)] = false;  // runs by two integrators tell less of convergence than two by one
    if (made_by.note.empty()) continue;
    goes_on_by_[index(who)] = made_by.integrator;
    verdict_.notes.push_back(fmt::format("{}: {}", what, made_by.note));
  }
  return pair;
}

RunPair RunChecks::run_both(const RunOptions& run, const char* what, std::vector<std::string>& failures,
                            const std::array<bool, 2>& may_switch) {
  progress_.begin(what);
  Running running{run, {}, {}};
  start(running, what, may_switch);
  return finish(running, what, failures);
}

RunPair RunChecks::integrate_beside_refined(const RunOptions& run, const SolverMakers* makers) {
  const char* what = name_of(Check::same_run);
  progress_.begin(what);
  Running running{run, {}, {}};
  start(running, what, may_switch_);
  if (makers != nullptr) {
    RunOptions refined = run;
    refined.rtol = refined_tolerance(run.rtol);
    ahead_ = std::make_unique<RunsAhead>(layout_.model(), *makers, refined,
                                         std::array{integrator_of(Who::cartesian), integrator_of(Who::relative)},
                                         name_of(Check::refined), turns_, progress_);
  }
  return finish(running, what, verdict_.failures);
}

/// Those that were begun beside the same run, if they were made as they would be now; else they are made now.
RunPair RunChecks::refined_at_first(const RunOptions& refined) {
  const std::array integrators{integrator_of(Who::cartesian), integrator_of(Who::relative)};
  const std::unique_ptr<RunsAhead> ahead = std::move(ahead_);
  if (ahead && ahead->options().rtol == refined.rtol && ahead->integrators() == integrators) {
    progress_.wait_for(name_of(Check::refined));
    if (auto pair = ahead->fetch(verdict_.failures)) return std::move(*pair);
  }
  return integrate(refined, Check::refined);
}

/// Where the required digits ask for more than what the refined check tries at first, and were not reached by that,
/// both solvers run once more, as much tighter as they ask. A solver whose own runs have converged goes on with the one
/// it has.
void RunChecks::tighten_as_asked(const RunPair& of_same_run, RunPair& pair) {
  const double asked = tightening_asked(verdict_);
  if (asked <= kTighterAtFirst || reaches_refined_needs(verdict_, pair)) return;
  const std::array<bool, 2> rests = have_converged(layout_, of_same_run, pair, verdict_);
  if (rests[0] && rests[1]) return;
  Running running{of_same_run.run, {}, {}};
  running.run.rtol = refined_tolerance(of_same_run.run.rtol, asked);
  progress_.begin(name_of(Check::refined));
  start(running, name_of(Check::refined), may_switch_, rests);
  RunPair tighter = finish(running, name_of(Check::refined), verdict_.failures);
  for (const Who who : kBothSolvers) {
    if (!rests[index(who)]) continue;
    tighter.is_mixed = true;
    tighter.trajectories[index(who)] = std::move(pair.trajectories[index(who)]);
    tighter.integrators[index(who)] = pair.integrators[index(who)];
  }
  pair = std::move(tighter);
  set_side_by_side(pair, Check::refined);
}

}  // namespace concord::compare
