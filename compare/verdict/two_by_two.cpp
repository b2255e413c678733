#include "compare/verdict/two_by_two.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/error.h"
#include "common/solver.h"
#include "compare/quantities/observe.h"
#include "compare/verdict/refinement.h"

namespace concord::compare {

namespace {

constexpr std::size_t kTableSamples = 41;

/// The row that stands farthest below its need on the first check that differs; reactions before what follows from
/// them.
const QuantityRow* row_that_differs(const Verdict& verdict) {
  for (const Check check : kChecks) {
    for (const auto* rows : {&verdict.rows, &verdict.others}) {
      const QuantityRow* worst = nullptr;
      for (const QuantityRow& row : *rows) {
        if (!is_judged(row) || !digits_of(row, check) || meets_need(row, check)) continue;
        if (worst == nullptr || margin(row, check) < margin(*worst, check)) worst = &row;
      }
      if (worst != nullptr) return worst;
    }
  }
  return nullptr;
}

}  // namespace

std::optional<TwoByTwo> two_by_two(const Model& model, const std::array<Solver*, 2>& solvers, const Verdict& verdict) {
  const QuantityRow* row = row_that_differs(verdict);
  if (row == nullptr || !verdict.trajectories[0] || !verdict.trajectories[1]) return std::nullopt;
  const QuantityLayout layout(model);
  const int place = layout.row_of(row->quantity);
  const auto& runs = verdict.trajectories;
  const std::size_t samples = std::min(runs[0]->samples.size(), runs[1]->samples.size());
  const std::size_t stride = (samples + kTableSamples - 1) / kTableSamples;
  TwoByTwo table;
  table.of = describe_owner(model, row->quantity) + ", " + describe_component(row->quantity);
  table.unit = unit_of(model, row->quantity);
  std::vector<double> times;
  std::array<std::vector<double>, 2> curves;
  for (std::size_t k = 0; k < samples; k += stride) {
    std::array<std::array<double, 2>, 2> value{};  // by algebra, by motion
    try {
      for (int motion = 0; motion < 2; ++motion) {
        const State& state = runs[motion]->samples[k].state;
        for (int algebra = 0; algebra < 2; ++algebra) {
          value[algebra][motion] = layout.observe(state, solvers[algebra]->evaluate(state))(place);
        }
      }
    } catch (const SolverError&) {
      continue;  // a state that one solver's constraints do not accept
    }
    ++table.samples;
    times.push_back(runs[0]->samples[k].state.t);
    for (std::size_t who = 0; who < 2; ++who) curves[who].push_back(value[who][who]);
    for (int who = 0; who < 2; ++who) {
      table.formulation[who] = std::max(table.formulation[who], std::abs(value[0][who] - value[1][who]));
      table.integration[who] = std::max(table.integration[who], std::abs(value[who][0] - value[who][1]));
    }
  }
  if (table.samples == 0) return std::nullopt;
  table.curves = compare_curves(times, curves);
  return table;
}

std::string describe(const TwoByTwo& table) {
  return fmt::format(
      "{}, largest over {} samples: formulation {:.2e} {} on cartesian's motion, {:.2e} on relative's; integration "
      "{:.2e} {} by cartesian's equations, {:.2e} by relative's; peaks {:.6g} {} at {:.4g} s and {:.6g} at {:.4g} s, "
      "RMS {:.2e} of the range, Sprague-Geers magnitude {:+.2e}, phase {:.2e}, combined {:.2e}",
      table.of, table.samples, table.formulation[0], table.unit, table.formulation[1], table.integration[0], table.unit,
      table.integration[1], table.curves.peak[0], table.unit, table.curves.t_peak[0], table.curves.peak[1],
      table.curves.t_peak[1], table.curves.rms_over_range, table.curves.magnitude, table.curves.phase,
      table.curves.combined);
}

}  // namespace concord::compare
