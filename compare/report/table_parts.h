#pragma once

#include <string>

#include "common/model.h"
#include "compare/verdict/verdict.h"

/// What stands above and below the tables of a verdict.
namespace concord::compare {

/// What was compared, in four lines: the machine, its constraints at the start, the run, and the digits that are
/// needed. What a solver could not find at its start is not known.
std::string table_head(const Verdict& verdict);

/// The third opinion: a table of the worst component of each joint's side, coupling and body, or of all, and a line
/// that sums them up; what it does not know, where it was not asked. Empty without a third opinion.
std::string format_third(const Model& model, const Verdict& verdict, bool all_rows);

}  // namespace concord::compare
