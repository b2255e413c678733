#include "compare/resolution/weighed_states.h"

#include <fmt/format.h>

namespace concord::compare {

WeighedStates weigh(const QuantityLayout& layout, const std::array<Solver*, 2>& solvers,
                    std::vector<SharedState> states, std::uint64_t seed) {
  WeighedStates weighed;
  int dropped = 0;
  std::string why;
  weighed.reports = report_ranks(solvers, states, dropped, why);
  if (dropped > 0) weighed.dropped = fmt::format("rank: in {} states: {}", dropped, why);
  weighed.beside_singular =
      SingularPoses(layout.model(), states, weighed.reports).leave_out_beside(states, weighed.reports);
  weighed.poses = SingularPoses(layout.model(), states, weighed.reports);
  weighed.states = std::move(states);
  weighed.mask = judged_states(layout, weighed.reports);
  leave_out_isolated(layout, weighed.states, weighed.reports, weighed.mask);
  weighed.open = open_reactions(layout.model(), weighed.states, weighed.reports);
  weighed.findings = compare_uniqueness(layout, weighed.states, weighed.reports);
  weighed.series = align(layout, weighed.states);
  weighed.resolution = measure_resolution(layout, solvers, weighed.states, weighed.mask,
                                          measure(layout, weighed.series), seed, projections_of(layout, weighed.open));
  weighed.singular = weighed.poses.reasons(solvers, weighed.states, weighed.reports);
  for (std::size_t k = 0; k < weighed.states.size(); ++k) {
    const std::string& within_round_off = weighed.resolution.singular[k];
    std::string& reason = weighed.singular[k];
    if (reason.empty() && !within_round_off.empty()) {
      reason = fmt::format("less than round-off from a state that both evaluate: {}", within_round_off);
    }
    if (!reason.empty()) weighed.mask.col(static_cast<Eigen::Index>(k)).setConstant(false);
  }
  return weighed;
}

WeighedRun weigh_run(const WeighedStates& weighed, int samples) {
  return {mask_of_run(weighed.mask, weighed.states, samples),
          resolution_of_run(weighed.resolution, weighed.states, samples)};
}

}  // namespace concord::compare
