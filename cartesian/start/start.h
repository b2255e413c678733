#pragma once

#include "cartesian/dynamics/equations.h"
#include "common/results.h"

namespace concord::cartesian {

/// The start of a machine.
struct Start {
  State state;
  bool searched = false;  // closed from another start than the guesses
};

/// Closes the machine at its start (close_start), with the values that its model keeps. Where these are more than it
/// has degrees of freedom the first independent ones are met, and the others as far as they are written. Throws
/// InputError where they are fewer, depend on each other or contradict each other, or where the guesses do not lead to
/// a pose that closes.
Start assemble_start(Equations& equations);

}  // namespace concord::cartesian
