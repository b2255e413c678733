#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/model.h"
#include "compare/quantities/columns.h"
#include "compare/quantities/convention.h"

/// The file of a reference: which columns it has, and how far its source may be off.
namespace concord::compare {

/// One component over time.
struct ReferenceColumn {
  Column column;
  std::vector<double> values;  // NaN: it says nothing there
  /// Stated error: part of the peak of the column's vector (of the run's or its own, whichever is larger), or absolute
  /// in the column's unit.
  double error = 0.0;
  bool is_relative = true;
  bool is_stated = true;         // false: it follows from the digits
  int digits = 0;                // of the number with the most, without leading zeros
  bool is_re_expressed = false;  // the runs are brought where it tells, see re_express()
};

struct Reference {
  std::string file;
  std::vector<double> times;
  std::vector<double> time_roundings;  // half of the last digit that each is written with [s]
  std::vector<int> lines;              // of the file, for messages
  std::vector<ReferenceColumn> columns;
  Conventions conventions;  // that the header states
};

/// Reads a reference: comma-separated values with a header as our own .reactions.csv, .elements.csv and .motion.csv
/// have it, any choice of their columns and of further_columns(), `t [s]` first:
///
///     # error = 0.5 %
///     # error D.child.T_z = 0.02 N m
///     t [s],D.child.F_x [N],D.child.T_z [N m]
///     0,12.1,0.31
///
/// Comment lines such as `# side = parent` and, of one joint, `# axes D = world` say the convention of joints'
/// reactions (Convention). The numbers may stand
/// in the long format, too, one line a number:
///
///     t,of,component,value
///     0,D,child.F_x,12.1
///
/// `F_x` alone is on the child's side there.
/// Comment lines say the error, of all columns or of one: in percent of the peak of the vector of which the column is a
/// component (force or torque on that side, place, speed; a number alone: its own peak), in the run or in the
/// reference, whichever is larger, but of no less than 1e-4 of the scale in the table, or in the column's own unit. The
/// sign of a set of Euler parameters means nothing and is chosen to fit. `nan` in the place of a number says nothing
/// there, and a column any_NAME of our own files is read and not judged. Throws InputError, with line, column and
/// reason, for a column that the model does not have, a wrong unit, a column with two errors, a number that is none, or
/// times that do not rise. A column without a stated error is `is_stated` false.
Reference read_reference(const std::filesystem::path& file, const Model& model);

}  // namespace concord::compare
