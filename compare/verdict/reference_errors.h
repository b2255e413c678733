#pragma once

#include "compare/quantities/reference_file.h"
#include "compare/verdict/reference_rows.h"
#include "compare/verdict/verdict.h"

/// How far the numbers of a reference may be off.
namespace concord::compare {

/// Beside a point of the output grid a time is nearer to it than this part of an interval.
inline constexpr double kOnGrid = 1e-6;

/// A column without a sign of its own: one of the Euler parameters of a body or of a ball.
bool has_free_sign(const Column& column);

/// The last time up to which two integrations of the motion can agree [s].
double last_judged(const Verdict& verdict);

/// The error of a column's source in the column's unit: as stated, in percent of the peak of its vector, or, where none
/// is stated, half of the last digit that is written or, if that is more, 1e-9 or `drift` of the peak; at most 1e-3 of
/// it. `largest`: the machine's largest number of that unit.
double error_of(const ReferenceColumn& column, const Verdict& verdict, const Reference& reference, double largest,
                double drift);

/// The most that counts as an error of a column where none is stated, 1e-3 of the peak of its vector.
double most_unstated(const ReferenceColumn& column, const Reference& reference);

/// What a run that is less exact than it is written leaves out of balance with concord's, of the peak: of each vector
/// the median over the times of its deviation, of all vectors that state no error the median of these, ten times that,
/// and at most 1e-3. So neither one time nor one joint that is wrong raises it. Zero if that median is more than 1e-3,
/// if there are fewer than five times, or if the reference does not begin with the run and as exactly as it is written:
/// who starts off another number has another machine.
double drift_of(const Standard& standard, const Reference& reference);

}  // namespace concord::compare
