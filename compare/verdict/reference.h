#pragma once

#include "common/model.h"
#include "compare/quantities/reference_file.h"
#include "compare/verdict/verdict.h"

/// A third column from outside: published or measured reactions and motions, with the error that their source states.
namespace concord::compare {

/// Throws InputError if a time of the reference is no output time of the run.
void check_times(const Reference& reference, const RunOptions& run);

/// Holds both solvers' runs in `verdict` against a reference and adds a row for each column, and a finding for each
/// that misses by more than its stated error, which names another column of the same owner that would fit. Throws
/// InputError if a time is no output time of the run.
void judge_reference(const Model& model, const Reference& reference, Verdict& verdict);

}  // namespace concord::compare
