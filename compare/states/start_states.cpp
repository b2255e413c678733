#include "compare/states/start_states.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "compare/states/modal_sizes.h"

namespace concord::compare {

namespace {

/// How far the bodies come in h seconds, by the start of their motion [of the machine's length, rad].
double way_of(const Model& model, const Sample& start, double h) {
  double way = 0.0;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const BodyState& body = start.state.bodies[i];
    const BodyAcceleration& rate = start.evaluation.bodies[i];
    way = std::max(way, (h * body.v + 0.5 * h * h * rate.vdot).norm() / model.length_scale());
    way = std::max(way, (h * body.omega + 0.5 * h * h * rate.omegadot).norm());
    if (body.a.size() == 0) continue;
    const VecX modes = h * body.adot + 0.5 * h * h * rate.addot;
    way = std::max(way, modal_sizes(model, i).cwiseProduct(modes).norm());
  }
  return way;
}

/// The closed state after a step of at most `longest`; nothing where the solver finds none.
std::optional<State> step_from(const Model& model, Solver& solver, const State& start, double longest) {
  constexpr double kShort = 0.01;
  constexpr int kHalvings = 60;
  constexpr int kTries = 5;
  auto evaluation = evaluation_unless_refused(solver, start);
  if (!evaluation) return std::nullopt;
  const Sample sample{start, std::move(*evaluation), 0.0};
  double h = longest;
  for (int k = 0; k < kHalvings && way_of(model, sample, h) > kShort; ++k) h *= 0.5;
  for (int k = 0; k < kTries; ++k, h *= 0.5) {
    std::optional<State> closed = solver.close(predict(model, sample, h));
    if (closed && accepts(solver, *closed)) return closed;
  }
  return std::nullopt;
}

}  // namespace

std::vector<OwnedState> states_from_starts(const Model& model, const std::array<Solver*, 2>& solvers,
                                           const std::array<State, 2>& starts, double longest) {
  std::vector<OwnedState> states;
  std::vector<OwnedState> later;
  for (const Who who : kBothSolvers) {
    const State& start = starts[index(who)];
    if (start.bodies.empty()) return {};
    states.push_back({start, who, 0});
    auto step = step_from(model, *solvers[index(who)], start, longest);
    if (step) later.push_back({std::move(*step), who, 1});
  }
  if (later.size() == states.size()) std::move(later.begin(), later.end(), std::back_inserter(states));
  return states;
}

Trajectory samples_of(Who owner, Solver& solver, const std::vector<OwnedState>& states) {
  Trajectory trajectory;
  for (const OwnedState& owned : states) {
    if (owned.owner != owner) continue;
    auto evaluation = evaluation_unless_refused(solver, owned.state);
    if (evaluation) trajectory.samples.push_back({owned.state, std::move(*evaluation), 0.0});
  }
  return trajectory;
}

}  // namespace concord::compare
