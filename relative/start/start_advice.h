#pragma once

#include <string>
#include <vector>

#include "common/start_words.h"
#include "relative/rank/scaled_closure.h"

/// What a start that is refused lacks: where its loops stay open, and what it could keep.
namespace concord::relative {

/// Moves these columns by Levenberg's and Marquardt's method on the sum of the squared residuals, which need not
/// vanish; leaves the closure measured there.
void come_nearest(const ScaledClosure& scaled, Coordinates& coordinates, Closure& closure,
                  const std::vector<int>& columns);

/// "where the other joints are closed, joint 'D', at which the loop is cut, is left open by 0.1 m along z ...": the gap
/// of the cut joint that is open most where the loops come nearest to closing with these values prescribed, from
/// `guess` on. Empty if a coupling is open farther.
std::string words_of_open_loop(const ScaledClosure& scaled, const Coordinates& guess, const PrescribedMask& prescribed);

/// Words whose coordinates (rows of positions) or speeds a start can keep at closed coordinates, as many as the machine
/// has degrees of freedom beside its drivers and modes, and independent: those with `role` keep first, then others in
/// the order of the model. None where there are no such words, or too many to be named.
std::vector<StartWord> words_to_keep(const ScaledClosure& scaled, const Coordinates& closed, ClosureRows rows,
                                     StartRole WordStart::*role);

}  // namespace concord::relative
