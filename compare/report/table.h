#pragma once

#include <string>
#include <vector>

#include "common/model.h"
#include "compare/verdict/verdict.h"

namespace concord::compare {

/// The verdict on one model as text: head, tables of reactions and of force elements, what else was compared,
/// differences and failures, and a last line with the rungs that were climbed. Compact: of each joint or element and
/// side the component that comes nearest to its need (or fails it most); `all_rows`: every component. Says nothing that
/// changes from run to run.
std::string format_verdict(const Model& model, const Verdict& verdict, bool all_rows);

/// Columns of one width each, `| a | b |`, under a rule; every line has as many cells as the first. The columns named
/// in `right` are aligned right.
std::string format_table(const std::vector<std::vector<std::string>>& lines, const std::vector<bool>& right);

/// "1 loop", "2 loops".
std::string plural(int count, const char* one, const char* many);

}  // namespace concord::compare
