#pragma once

#include "cartesian/dynamics/equations.h"
#include "common/results.h"

namespace concord::cartesian {

/// The start of a machine.
struct Start {
  State state;
  bool searched = false;  // closed from another start than the guesses
};

/// Closes the machine at its start (close_start), with the values that its model keeps. Throws InputError where they
/// are not as many as the machine has degrees of freedom, depend on each other or contradict each other, or where the
/// guesses do not lead to a pose that closes.
Start assemble_start(Equations& equations);

}  // namespace concord::cartesian
