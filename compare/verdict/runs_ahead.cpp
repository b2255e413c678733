#include "compare/verdict/runs_ahead.h"

#include <fmt/format.h>

#include <utility>

#include "common/error.h"

namespace concord::compare {

namespace {

/// Thrown in the thread of a run that nobody wants any more: no error of a model or a solver.
struct Abandoned {};

}  // namespace

RunsAhead::RunsAhead(const Model& model, const SolverMakers& makers, const RunOptions& run,
                     const std::array<std::string, 2>& integrators, const char* what, Turns& turns,
                     CheckProgress& progress)
    : run_(run), integrators_(integrators), what_(what), turns_(turns), progress_(progress) {
  for (const Who who : kBothSolvers) {
    running_[index(who)] = std::async(std::launch::async, [this, who, &model, &makers, place = turns.take()] {
      return make(who, model, makers, place);
    });
  }
}

RunsAhead::~RunsAhead() {
  abandoned_ = true;
  for (std::future<Trajectory>& one : running_) {
    if (one.valid()) one.wait();
  }
}

Trajectory RunsAhead::make(Who who, const Model& model, const SolverMakers& makers, int place) {
  constexpr long kMostEvaluations = 1'000'000;
  const Turns::Held turn(turns_, place);
  const auto go_on = [this] {
    if (abandoned_) throw Abandoned{};
  };
  go_on();
  const auto solver = who == Who::cartesian ? makers.cartesian(model) : makers.relative(model);
  RunOptions own = run_;
  own.integrator = integrators_[index(who)];
  own.most_evaluations = kMostEvaluations;
  return solver->integrate(own, [&](double t) {
    go_on();
    progress_.advance(what_, who, t / own.until);
  });
}

std::optional<RunPair> RunsAhead::fetch(std::vector<std::string>& failures) {
  RunPair pair{run_, {}, {}, {}, {}, integrators_};
  std::vector<std::string> stopped;
  bool is_spent = false;
  for (const Who who : kBothSolvers) {
    try {
      pair.trajectories[index(who)] = running_[index(who)].get();
    } catch (const EvaluationsSpent&) {
      is_spent = true;
    } catch (const SolverError& error) {
      stopped.push_back(fmt::format("{}: {}", what_, error.what()));
    }
  }
  if (is_spent) return std::nullopt;
  failures.insert(failures.end(), stopped.begin(), stopped.end());
  return pair;
}

}  // namespace concord::compare
