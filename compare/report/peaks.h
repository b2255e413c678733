#pragma once

#include <string>

#include "common/model.h"
#include "common/results.h"
#include "compare/quantities/agreement.h"

/// The largest forces of a run, for its reader. Never judged.
namespace concord::compare {

/// A table of the reactions' largest |F| and |T| for each joint and side, and format_drives(). A peak stands at the
/// first sample whose size is within 1e-6 of the largest. `unique`: the layout's quantities in the samples of the run;
/// samples in which some component is open count for nothing, and "not unique" stands where none is left. nullptr: all
/// count.
std::string format_peaks(const Model& model, const Trajectory& run, const Mask* unique = nullptr);

/// A table of the forces along coordinates, a row for each driver, motor, spring, damper and coupling: the largest, its
/// root mean square over the samples, and the largest power that it delivers to the motion (none of a coupling, whose
/// power vanishes in all). Positive: it pushes the coordinate, or the sum of a coupling, to grow. Empty if there are
/// none.
std::string format_drives(const Model& model, const Trajectory& run, const Mask* unique = nullptr);

}  // namespace concord::compare
