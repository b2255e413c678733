#pragma once

#include <string>
#include <vector>

#include "common/solver.h"
#include "compare/audit/balance.h"
#include "compare/audit/energy.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/observe.h"

/// What holds of one solver's run without the other one: its constraints, its free bodies, its energy, and what of its
/// wrenches is unique.
namespace concord::compare {

struct RunCheck {
  AuditReport audit;
  EnergyReport energy;
  double energy_allowed = 0.0;  // relative
  /// Rows: the layout's quantities; columns: samples.
  Mask unique;
  /// Why the run is no fact; empty if it is one.
  std::vector<std::string> failures;

  [[nodiscard]] bool holds() const { return failures.empty(); }
};

/// Asks the solver for the closure and the rank of every sample, audits every sample, and holds the energy over the
/// run. Throws IncompleteResult if the trajectory lacks something.
RunCheck check_run(const QuantityLayout& layout, Solver& solver, const Trajectory& trajectory,
                   const RunOptions& options);

/// The checks as lines of text, and the components that are not unique with the share of samples.
std::string format_run_check(const QuantityLayout& layout, std::string_view solver, const RunCheck& check);

}  // namespace concord::compare
