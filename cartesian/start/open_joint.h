#pragma once

#include <optional>
#include <string>

#include "cartesian/rank/closing.h"
#include "common/start_words.h"

namespace concord::cartesian {

/// What is missing between where the child stands in the joint's parent frame and the nearest place that the joint's
/// type permits there, by Newton's method on what it forbids; `length` makes displacements and turns comparable [m].
/// Nothing if that does not converge. A_C is not set.
std::optional<JointGap> gap_of(const joints::JointType& type, const RelativeMotion& motion, double length);

/// "joints A, B and coupling 'gears'": what is left open.
std::string named_open(const Closing& closing);

/// Where a machine is open that does not close from q and Y, in words: "where the others are closed, joint 'D' is left
/// open by 0.1 m along z ...". Of the joints that `closing` leaves open one is taken at which the others close: the cut
/// joint that the model names, else the last in the model; if none is such, the one with the largest residual of all.
/// Empty if nothing is known.
std::string words_of_open_joint(Equations& equations, double t, Hold hold, const Closing& closing, const VecX& q,
                                const VecX& Y);

}  // namespace concord::cartesian
