#pragma once

#include <string>

#include "common/model.h"
#include "common/solver.h"

namespace concord::compare {

/// Hinges that were meant to be parallel and are not, because their axes were rounded: of all pairs on one body whose
/// axes enclose less than 1e-4 rad and more than round-off, the one that encloses most, in a sentence; empty if there
/// is none, or no loop, or if drivers move the machine. A planar loop with such axes has a constraint more than it was
/// meant to have, and does not move.
std::string note_on_near_parallel_axes(const Model& model);

/// Whether a machine may not move as it was meant to, so that the note is worth a look.
bool is_motion_doubtful(const RankReport& rank);

/// What a solver says of a machine that it cannot start, with such a note if there is one.
InputError explained(const InputError& error, const Model& model);

}  // namespace concord::compare
