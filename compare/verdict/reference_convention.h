#pragma once

#include "common/model.h"
#include "common/results.h"
#include "compare/quantities/reference_file.h"
#include "compare/verdict/reference_hints.h"
#include "compare/verdict/verdict.h"

/// In which other convention the numbers of a reference would be equal.
namespace concord::compare {

/// Whether a solver is off a column by more than is allowed.
bool is_off(const ReferenceRow& row);

/// A reference whose columns are those that its header's conventions mean, of the sign that concord has.
Reference in_stated_convention(const Model& model, const Reference& as_named);

/// Searches the conventions for those in which every reaction in `as_named` is within the allowed error of its row
/// where it is unique (`known`: a run with NaN where a number is not); first one for all joints, then for each joint
/// that is off. Tells all that fit, with the header lines that say them, in a note and in the hints of the rows.
/// Returns whether every judged row is equal then.
bool find_conventions(const Model& model, const RunsAtTimes& runs, const Reference& as_named, const Trajectory& known,
                      Verdict& verdict);

}  // namespace concord::compare
