#include "compare/verdict/same_state.h"

#include <fmt/format.h>

#include <iterator>
#include <string>
#include <utility>

#include "common/error.h"
#include "compare/resolution/jumps.h"
#include "compare/resolution/resolution.h"

namespace concord::compare {

SameState::SameState(const QuantityLayout& layout, const std::array<Solver*, 2>& solvers, std::uint64_t seed,
                     Judge& judge, Verdict& verdict)
    : layout_(layout), solvers_(solvers), seed_(seed), judge_(judge), verdict_(verdict) {}

std::vector<Measured> SameState::judge_states(SharedStates found, SharedStates perturbed) {
  for (const SharedStates* part : {&found, &perturbed}) note_failures(*part);
  std::move(perturbed.states.begin(), perturbed.states.end(), std::back_inserter(found.states));
  weighed_ = weigh(layout_, solvers_, std::move(found.states), seed_);
  if (is_singular_throughout(found)) forget_neighbours();
  judge_.judge_uniqueness(weighed_);
  note_singular_start();
  for (const SharedStates* part : {&found, &perturbed}) note_refusals(part->refusals);
  verdict_.same_state.samples = static_cast<int>(weighed_.states.size());
  if (weighed_.states.empty()) return {};
  std::vector<Measured> measured = judge_.measure_check(weighed_.series, weighed_.budget(), Check::same_state);
  constexpr double kNeedAtJumps = 8.0;  // digits: jumps are large
  const auto sample_of = [&](std::size_t k) {
    return Sample{weighed_.states[k].state, weighed_.states[k].evaluations[0], 0.0};
  };
  const auto jumps =
      widen_at_jumps(layout_, solvers_, weighed_.series, measured, sample_of, kNeedAtJumps, weighed_.resolution.both);
  if (!jumps.empty()) {
    measured = judge_.measure_check(weighed_.series, weighed_.budget(), Check::same_state);
    verdict_.notes.push_back(note_on_jumps(jumps, Check::same_state));
  }
  judge_.note_singular_states(weighed_);
  judge_.find_differences_on(weighed_.series, measured, Check::same_state);
  note_resolution();
  return measured;
}

void SameState::note_failures(const SharedStates& shared) {
  verdict_.singular_states += static_cast<int>(shared.singular.size());
  if (!shared.singular.empty()) verdict_.failures.push_back(shared.singular.front());
  if (!shared.failures.empty()) verdict_.failures.push_back(shared.failures.front());
}

/// Whether a solver calls every state that they found a singular pose, or finds a lower rank in all of them.
bool SameState::is_singular_throughout(const SharedStates& found) const {
  bool some = !found.singular.empty();
  for (std::size_t k = 0; k < weighed_.states.size(); ++k) {
    if (weighed_.states[k].row < 0) continue;  // perturbed
    if (weighed_.singular[k].empty()) return false;
    some = true;
  }
  return some;
}

/// A loop that is locked in a singular pose closes beside it only by the root of round-off: such states, though of full
/// rank, tell nothing.
void SameState::forget_neighbours() {
  weighed_.mask.setConstant(false);
  weighed_.findings.clear();
}

/// A rank at the start that is lower than in other states is a singular pose.
void SameState::note_singular_start() {
  for (std::size_t who = 0; who < 2; ++who) {
    const RankReport& at_start = verdict_.solvers[who].rank;
    if (!weighed_.poses.is_singular(at_start, who)) continue;
    verdict_.notes.push_back(
        fmt::format("{}: the start pose is singular: rank {} there, {} at a neighbouring pose; motion may branch",
                    solvers_[who]->name(), at_start.rank, weighed_.poses.general_rank(who)));
  }
}

/// In a singular pose the solvers need not close alike, nor beside one in which a machine is locked: there a closing
/// holds the root of round-off. Such a state is counted, and no difference.
void SameState::note_refusals(const std::vector<RefusedState>& refused) {
  std::vector<std::string> elsewhere;
  std::vector<std::string> there;
  for (const RefusedState& one : refused) {
    (is_at_singular_pose(one.state) ? there : elsewhere).push_back(one.why);
  }
  if (!there.empty()) {
    verdict_.singular_states += static_cast<int>(there.size());
    const std::string more = there.size() > 1 ? fmt::format("; so are {} more states", there.size() - 1) : "";
    verdict_.failures.push_back(fmt::format("the pose is singular: {}{}", there.front(), more));
  }
  if (elsewhere.empty()) return;
  verdict_.findings.push_back(
      {elsewhere.front(),
       fmt::format("same state: {} such states: the closures differ; hold what the joint forbids against what it "
                   "permits",
                   elsewhere.size())});
}

/// Whether a state's owner finds a lower rank there than in general, or one that is attached by a singular value which
/// may be round-off.
bool SameState::is_at_singular_pose(const OwnedState& state) const {
  try {
    const RankReport report = solvers_[index(state.owner)]->rank(state.state);
    return weighed_.poses.is_singular(report, index(state.owner)) || report.undecided;
  } catch (const SolverError&) {
    return false;
  }
}

void SameState::note_resolution() {
  if (weighed_.resolution.unknown_states > 0) {
    verdict_.notes.push_back(
        fmt::format("resolution unknown in {} of {} states: fewer than {} of {} draws within round-off were accepted; "
                    "judged there by the need alone",
                    weighed_.resolution.unknown_states, weighed_.states.size(), kFewestDraws, kDraws));
  }
  if (weighed_.resolution.closings_left_out > 0) {
    verdict_.notes.push_back(fmt::format("resolution: {} closings found another state and were left out",
                                         weighed_.resolution.closings_left_out));
  }
}

}  // namespace concord::compare
