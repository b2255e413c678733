#pragma once

#include <string>

#include "compare/verdict/verdict.h"

namespace concord::compare {

/// What was compared, in four lines: the machine, its constraints at the start, the run, and the digits that are
/// needed. What a solver could not find at its start is not known.
std::string table_head(const Verdict& verdict);

}  // namespace concord::compare
