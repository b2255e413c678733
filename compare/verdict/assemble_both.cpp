#include "compare/verdict/assemble_both.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>

#include "common/error.h"
#include "compare/quantities/motions.h"
#include "compare/resolution/resolution.h"
#include "compare/states/branch.h"
#include "compare/states/singular_pose.h"
#include "compare/verdict/blame.h"

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

/// Why two starts beside a singular pose are no difference, though they differ: closing knows them no better. Empty for
/// all others. A parallelogram 6e-6 rad from flat.
std::string why_start_is_unknown(const Model& model, const std::array<State, 2>& starts, const Verdict& verdict) {
  const std::array<const RankReport*, 2> ranks{&verdict.solvers[0].rank, &verdict.solvers[1].rank};
  const RankReport& lower = ranks[0]->smallest_kept < ranks[1]->smallest_kept ? *ranks[0] : *ranks[1];
  const double apart = distance(starts[0], starts[1], {model, starts[0]});
  if (!is_beside_singular(lower) || apart <= kSameClosing || apart > known_from_closing(lower)) return "";
  std::array<Trajectory, 2> runs;
  for (std::size_t who = 0; who < 2; ++who) runs[who].samples = {{starts[who], {}, 0.0}};
  return fmt::format(
      "the start is beside a singular pose: one of the independent constraints has a relative singular value of {:.1e} "
      "there (need {:g}), so that closing knows few digits of it, and the starts of both solvers differ by {:.1e} of "
      "their size, most in the {}: start farther from that pose",
      lower.smallest_kept, kBesideSingular, apart, compare_motions(model, {&runs[0], &runs[1]}).worst);
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
  if (!verdict.failures.empty()) return starts;
  if (std::string why = why_start_is_unknown(model, starts, verdict); !why.empty()) {
    verdict.failures.push_back(std::move(why));
  }
  return starts;
}

}  // namespace concord::compare
