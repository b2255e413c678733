#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/quantities/convention.h"
#include "compare/quantities/reference_file.h"
#include "compare/verdict/reference_hints.h"
#include "compare/verdict/verdict.h"

/// Row by row: the numbers of a reference beside those of both solvers.
namespace concord::compare {

/// What the numbers of a reference are held against, at its times.
struct Standard {
  const Model& model;
  RunsAtTimes runs;
  std::vector<const Sample*> known;       // with NaN where a number is not unique
  std::map<std::string, double> largest;  // number of the machine, by unit
  /// At each time what each self-stress of the machine exerts; none where all is unique or the count is not clear.
  std::vector<std::vector<Sample>> self_stresses;
  std::shared_ptr<const std::vector<Sample>> owned;  // samples that no run holds
};

/// The machine's largest number of a unit; zero if it has none.
double size_of(const Standard& standard, const std::string& unit);

/// At the samples of a run that have these numbers; `known`: the first run with NaN where a number is not unique, or
/// the run itself. The verdict, the model and `known` must outlive it.
Standard standard_of(const Model& model, const Verdict& verdict, const std::vector<std::size_t>& samples,
                     const Trajectory& known);

/// The same with the wrenches of joints where conventions tell them (re_express).
Standard re_expressed(const Standard& standard, const Conventions& conventions);

struct JudgedRows {
  std::vector<ReferenceRow> rows;  // one for each column
  double drift = 0.0;              // that counts as an error where none is stated, of the peak (drift_of)
  int left_out = 0;                // numbers that may be one of many, which is not clear
};

/// Holds every column of a reference, whose conventions are concord's, against both solvers. Where it is unique it is
/// equal if neither is off by more than the error of its source. Where it is one of many, the differences of all such
/// columns at that time must be one sum of multiples of the self-stresses, but for those errors: each column is then
/// one of infinitely many, and else wrong. What is neither is left out.
JudgedRows judge_rows(const Standard& standard, const Reference& reference);

/// What a column that is wrong would fit; see what_would_fit().
std::string hint_at_wrong(const Standard& standard, const Reference& reference, std::size_t column, double allowed);

}  // namespace concord::compare
