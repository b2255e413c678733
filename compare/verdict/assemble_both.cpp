#include "compare/verdict/assemble_both.h"

#include <fmt/format.h>

#include <optional>

#include "common/error.h"
#include "compare/verdict/blame.h"
#include "compare/verdict/branch.h"

namespace concord::compare {

namespace {

/// Why a solver refuses the model; `is_not_found`: it says that there is no start.
struct Refusal {
  InputError error;
  bool is_not_found;
};

/// Whether a refusal is the solver's mistake: it says that there is no start, though the other one's has all that the
/// model keeps, or the comparator's own count of the constraints speaks against it.
bool is_mistaken(const Model& model, const std::array<Solver*, 2>& solvers, const std::array<State, 2>& starts, Who who,
                 const Refusal& refusal, std::uint64_t seed, bool explains) {
  const State& of_other = starts[1 - index(who)];
  if (of_other.bodies.empty()) return false;
  if (refusal.is_not_found && obeys_the_model(model, of_other)) return true;
  if (!explains) return false;
  try {
    const std::optional<Attribution> cause = cause_of_stop(model, solvers, owned_starts(starts), seed);
    return cause && cause->solver == static_cast<int>(index(who));
  } catch (const SolverError&) {  // nothing is known of the state: the refusal stands
    return false;
  }
}

}  // namespace

std::array<State, 2> assemble_both(const Model& model, const std::array<Solver*, 2>& solvers, std::uint64_t seed,
                                   bool explains, Verdict& verdict) {
  std::array<State, 2> starts;
  std::array<std::optional<Refusal>, 2> refusals;
  for (const Who who : kBothSolvers) {
    Solver& solver = *solvers[index(who)];
    try {
      starts[index(who)] = solver.assemble();
      verdict.solvers[index(who)].rank = solver.rank(starts[index(who)]);
      verdict.solvers[index(who)].cut_joints = solver.cut_joints();
    } catch (const SolverError& error) {
      verdict.failures.emplace_back(error.what());
    } catch (const StartNotFound& error) {
      refusals[index(who)] = Refusal{error, true};
    } catch (const InputError& error) {
      refusals[index(who)] = Refusal{error, false};
    }
  }
  for (const Who who : kBothSolvers) {
    const std::optional<Refusal>& refusal = refusals[index(who)];
    if (!refusal) continue;
    if (!is_mistaken(model, solvers, starts, who, *refusal, seed, explains)) throw InputError(refusal->error);
    verdict.failures.push_back(fmt::format("{} refuses the start that {} finds: {}", solvers[index(who)]->name(),
                                           solvers[1 - index(who)]->name(), refusal->error.what()));
  }
  return starts;
}

}  // namespace concord::compare
