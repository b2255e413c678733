#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compare/observe.h"
#include "compare/verdict.h"

/// A third column from outside: published or measured reactions, with the error that their source states.
namespace concord::compare {

/// One component over time.
struct ReferenceColumn {
  std::string name;  // "D.child.T_z"
  Quantity quantity;
  std::vector<double> values;
  /// Stated error: part of the scale of the row (the joint's peak), or absolute [N, N m].
  double error = 0.0;
  bool is_relative = true;
};

struct Reference {
  std::string file;
  std::vector<double> times;
  std::vector<int> lines;  // of the file, for messages
  std::vector<ReferenceColumn> columns;
};

/// Reads a reference: comma-separated values with a header as our own .reactions.csv and .elements.csv have it, any
/// choice of their columns, `t [s]` first:
///
///     # error = 0.5 %
///     # error D.child.T_z = 0.02 N m
///     t [s],D.child.F_x [N],D.child.T_z [N m]
///     0,12.1,0.31
///
/// Comment lines say the error, of all columns or of one: in percent of the row's scale (the joint's peak |F| or torque
/// scale, as in the table) or in the column's own unit. Throws InputError, with line and reason, for a column that the
/// model does not have, a wrong unit, a column without an error, a number that is none, or times that do not rise.
Reference read_reference(const std::filesystem::path& file, const Model& model);

/// Throws InputError if a time of the reference is no output time of the run.
void check_times(const Reference& reference, const RunOptions& run);

/// Holds both solvers' runs in `verdict` against a reference and adds a row for each column, and a finding for each
/// that misses by more than its stated error. Throws InputError if a time is no output time of the run.
void judge_reference(const Model& model, const Reference& reference, Verdict& verdict);

}  // namespace concord::compare
