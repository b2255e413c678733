#include "compare/verdict/blame.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "common/error.h"

namespace concord::compare {

namespace {

/// What a solver says, or nothing where it stops.
template <class Ask>
auto said(const Ask& ask) -> decltype(ask()) {
  try {
    return ask();
  } catch (const std::exception&) {
    return {};
  }
}

StatedConstraints ask(Solver& solver, const State& state) {
  using Answer = StatedConstraints::Answer;
  StatedConstraints stated;
  stated.rank = said([&] { return std::optional(solver.rank(state)); });
  stated.tangent = said([&] { return solver.tangent(state); });
  stated.closed = said([&] { return solver.close(state); });
  try {
    (void)solver.evaluate(state);
    stated.answer = Answer::given;
  } catch (const SingularPose& error) {
    stated.answer = Answer::singular;
    stated.words = error.what();
  } catch (const OpenState& error) {
    stated.answer = Answer::open;
    stated.words = error.what();
    stated.place = error.place();
  } catch (const std::exception& error) {
    stated.words = error.what();
  }
  return stated;
}

}  // namespace

std::vector<EvaluatedState> evaluated(const std::vector<SharedState>& states) {
  std::vector<EvaluatedState> views;
  for (const SharedState& one : states) views.push_back({&one.state, {&one.evaluations[0], &one.evaluations[1]}});
  return views;
}

std::vector<bool> ambiguous_joints(const QuantityLayout& layout, const Mask& mask) {
  std::vector<bool> ambiguous(layout.model().joints.size(), false);
  for (std::size_t row = 0; row < layout.quantities().size(); ++row) {
    const Quantity& quantity = layout.quantities()[row];
    if (quantity.kind != Kind::reaction && quantity.kind != Kind::total) continue;
    const auto of_row = static_cast<Eigen::Index>(row);
    if (of_row < mask.rows() && !mask.row(of_row).all()) ambiguous[quantity.owner] = true;
  }
  return ambiguous;
}

std::vector<OwnedState> states_of_ranks(const Model& model, const std::array<Solver*, 2>& solvers,
                                        const std::vector<OwnedState>& found, std::uint64_t seed) {
  std::vector<OwnedState> states;
  if (found.empty()) return states;
  const auto most = static_cast<std::size_t>(kStatesOfRanks);
  const std::size_t stride = (found.size() + most - 1) / most;
  for (std::size_t k = 0; k < found.size(); k += stride) states.push_back(found[k]);
  StatePerturbation perturbation(model, found, seed);
  for (std::size_t tries = 0; tries < 4 * most && states.size() < most; ++tries) {
    constexpr double kNear = 0.5;
    const OwnedState& base = found[tries % found.size()];
    const State perturbed = perturbation.perturb(base.state, kNear);
    auto closed = said([&] { return solvers[index(base.owner)]->close(perturbed); });
    if (closed) states.push_back({std::move(*closed), base.owner, -1});
  }
  return states;
}

std::vector<AskedState> ask_of_constraints(const std::array<Solver*, 2>& solvers,
                                           const std::vector<OwnedState>& states) {
  std::vector<AskedState> asked;
  for (const OwnedState& one : states) {
    asked.push_back({one.state, index(one.owner), {ask(*solvers[0], one.state), ask(*solvers[1], one.state)}});
  }
  return asked;
}

std::vector<OwnedState> owned_starts(const std::array<State, 2>& starts) {
  std::vector<OwnedState> owned;
  for (const Who who : kBothSolvers) {
    if (!starts[index(who)].bodies.empty()) owned.push_back({starts[index(who)], who});
  }
  return owned;
}

std::optional<Attribution> cause_of_stop(const Model& model, const std::array<Solver*, 2>& solvers,
                                         const std::vector<OwnedState>& found, std::uint64_t seed) {
  return find_cause_of_stop(model, ask_of_constraints(solvers, states_of_ranks(model, solvers, found, seed)));
}

bool answers_hold(const Verdict& verdict) {
  return verdict.same_state.passed && verdict.audit.passed && verdict.rank_agrees;
}

std::string blame_of_run(const Verdict& verdict) {
  const auto& [one, other] = verdict.solvers;
  const bool one_loses = keeps_energy(verdict, one) != keeps_energy(verdict, other);
  if (one_loses && !verdict.same_run.passed) {
    return fmt::format(
        "to blame: the run of {}, not what it answers: in the same states both solvers agree and the audit holds, and "
        "this run alone does not keep its energy; look at its steps, projections, events, and at the joint "
        "accelerations that it integrates",
        keeps_energy(verdict, one) ? other.name : one.name);
  }
  if (one_loses) {
    return fmt::format(
        "to blame: {}, in the power that it integrates: both runs agree and the audit holds, and the work of its "
        "drivers, springs, dampers and forces is not what the motion gains",
        keeps_energy(verdict, one) ? other.name : one.name);
  }
  return "to blame: a run, not what is answered: in the same states both solvers agree and the audit holds; look at "
         "steps, projections, events, and at the joint accelerations and the power that are integrated";
}

std::string blame_of_stop(const Verdict& verdict) {
  return fmt::format(
      "to blame: the run of {}, not what it answers: in the same states both solvers agree and the audit holds; look "
      "at its steps, projections and events, or take another integrator",
      verdict.solvers[verdict.trajectories[0] ? 1 : 0].name);
}

}  // namespace concord::compare
