#pragma once

#include "common/model.h"
#include "compare/quantities/reference_file.h"
#include "compare/verdict/reference_rows.h"
#include "compare/verdict/verdict.h"

/// In which other convention the numbers of a reference would be equal.
namespace concord::compare {

/// A reference whose columns are those that its header's conventions mean, of the sign that concord has.
Reference in_stated_convention(const Model& model, const Reference& as_named);

/// Searches the conventions of the reactions in `as_named`, where rows of `verdict` are wrong: for those in which none
/// is, first of all joints together, then of each joint that has a wrong row. Tells all that fit in a finding, with the
/// lines that say them, and gives the rows the words that they have there.
void find_conventions(const Standard& standard, const Reference& as_named, Verdict& verdict);

}  // namespace concord::compare
