#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/solver.h"
#include "compare/attribution/attribution.h"
#include "compare/attribution/ranks.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/align.h"
#include "compare/states/states.h"
#include "compare/verdict/verdict.h"

/// What both solvers say of their constraints, for compare/attribution to judge: also where one of them stops.
namespace concord::compare {

/// States that both solvers evaluated, as compare/attribution takes them; they must outlive what is returned.
std::vector<EvaluatedState> evaluated(const std::vector<SharedState>& states);

/// Joints of whose reactions and totals some component is not unique in some state.
std::vector<bool> ambiguous_joints(const QuantityLayout& layout, const Mask& mask);

/// So many states are asked about.
inline constexpr int kStatesOfRanks = 8;

/// Some of the states that the solvers found, spread over them, and perturbed ones if these are few, because a rank
/// belongs to a pose: closed by a solver that can.
std::vector<OwnedState> states_of_ranks(const Model& model, const std::array<Solver*, 2>& solvers,
                                        const std::vector<OwnedState>& found, std::uint64_t seed);

/// Asks both in every state. What stops a solver is its answer.
std::vector<AskedState> ask_of_constraints(const std::array<Solver*, 2>& solvers,
                                           const std::vector<OwnedState>& states);

/// The starts that solvers found; states without bodies are none.
std::vector<OwnedState> owned_starts(const std::array<State, 2>& starts);

/// Why a solver stops where the other one goes on, from what both say of their constraints in states that they found.
std::optional<Attribution> cause_of_stop(const Model& model, const std::array<Solver*, 2>& solvers,
                                         const std::vector<OwnedState>& found, std::uint64_t seed);

/// In the same states both solvers agree, in their ranks too, and the audit holds.
bool answers_hold(const Verdict& verdict);

/// A note where answers hold and runs do not. The run that does not keep its energy is to blame, if the other one does;
/// where both runs agree all the same, it is the power that one solver integrates.
std::string blame_of_run(const Verdict& verdict);

/// The same where one solver's run stops, and the other one's goes on to its end.
std::string blame_of_stop(const Verdict& verdict);

}  // namespace concord::compare
