#include <fmt/format.h>

#include <cstdio>

#include "common/error.h"
#include "common/model_file.h"
#include "compare/agreement.h"
#include "compare/needs.h"
#include "compare/refinement.h"
#include "compare/weighed_states.h"
#include "tests/faults/parameter_scan.h"

namespace concord::compare {

bool differs_at_same_state(const Model& model, const std::array<Solver*, 2>& solvers,
                           const std::vector<OwnedState>& states) {
  const Layout layout(model);
  SharedStates shared = share(solvers, states);
  if (!shared.refusals.empty() || !shared.failures.empty()) return true;
  const WeighedStates weighed = weigh(layout, solvers, std::move(shared.states), kSeed);
  Verdict verdict;
  make_rows(layout, verdict);
  record(layout, measure(layout, weighed.series, weighed.budget()), Rung::same_state, verdict);
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const Row& row : *rows) {
      if (row.unique && row.same_state && !climbs(row, Rung::same_state)) return true;
    }
  }
  return false;
}

}  // namespace concord::compare

/// Prints "model, fault, solver, smallest size seen" for each model file named.
int main(int argc, char** argv) {
  using namespace concord;
  using namespace concord::compare;
  for (int k = 1; k < argc; ++k) {
    const Model model = read_model(argv[k]);
    try {
      ParameterScan scan(model);
      fmt::print(stderr, "{}\n", scan.ratios());
      for (const ParameterFault& fault : parameter_faults(model)) {
        for (const Who who : {Who::cartesian, Who::relative}) {
          const auto size = scan.smallest_seen(fault, who);
          fmt::print("{},{},{},{}\n", model.name, fault.name, kSolverNames[index(who)],
                     size ? fmt::format("{:.2e}", *size) : "never");
        }
      }
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}: {}\n", model.name, error.what());
    }
    std::fflush(stdout);
  }
}
