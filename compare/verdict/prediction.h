#pragma once

#include "common/solver.h"

namespace concord::compare {

/// A guess of the state h seconds on, to the second order; hints of coordinates move on with their speeds.
State predict(const Model& model, const Sample& now, double h);

}  // namespace concord::compare
