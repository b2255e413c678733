#pragma once

#include <vector>

#include "cartesian/rank/closing.h"

namespace concord::cartesian {

/// How a start was closed.
struct ClosedStart {
  Closing closing;        // of the model's own guesses, if nothing closed
  bool searched = false;  // from another start than the guesses
};

/// Closes the machine at its start, from the poses and coordinates that its model guesses, with what is kept held; q, Y
/// and the turns counted by `equations` are those found. Turns that are not guessed start at zero, where the misfit may
/// be stationary (a linkage that is stretched): Newton's method then ends there. If the guesses do not close, a dozen
/// reproducible starts are tried in which coordinates that the model does not state lie anywhere and guesses lie round
/// about; of those that close the one nearest to the guesses is taken. Where none does, q and Y are what the guesses
/// led to.
ClosedStart close_start(Equations& equations, VecX& q, VecX& Y);

/// From the guesses alone: comes as near to what the start keeps as that goes, then closes with nothing of it held.
Closing close_without_kept(Equations& equations, VecX& q, VecX& Y);

}  // namespace concord::cartesian
