#pragma once

#include <string>

#include "common/model.h"
#include "compare/verdict/verdict.h"

/// The third opinion as a table.
namespace concord::compare {

/// A table of the worst component of each joint's side, coupling and body, or of all, and a line that sums them up;
/// what it does not know, where it was not asked. Empty without a third opinion.
std::string format_third(const Model& model, const Verdict& verdict, bool all_rows);

}  // namespace concord::compare
