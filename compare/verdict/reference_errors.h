#pragma once

#include "compare/quantities/reference_file.h"
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
/// is stated, half of the last digit that is written. `largest`: the machine's largest number of that unit.
double error_of(const ReferenceColumn& column, const Verdict& verdict, const Reference& reference, double largest);

}  // namespace concord::compare
