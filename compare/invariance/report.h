#pragma once

#include <string>
#include <utility>
#include <vector>

#include "compare/invariance/invariance_checks.h"

namespace concord::compare::invariance {

/// The checks of one model as text: a head, a line for each move and solver, what stays as it is, differences, and a
/// last line with the verdict. Says nothing that changes from run to run.
std::string format_checks(const Model& model, const InvarianceChecks& checks);

/// The same as JSON text (keys: compare/invariance/README.md): of one model, or of several by name.
std::string format_checks_json(const std::vector<std::pair<const Model*, const InvarianceChecks*>>& all_checks,
                               bool several_asked);

/// Differences, refusals and failures, a line each.
std::vector<std::string> findings_of(const Model& model, const InvarianceChecks& checks);

/// The row that is nearest to its need, over all moves; nullptr if nothing was judged.
const MoveRow* nearest_row(const InvarianceChecks& checks);

/// "13.4 of 15.1": digits that agree, and of how many that double precision resolves.
std::string format_nearest(const Nearest& nearest);

}  // namespace concord::compare::invariance
