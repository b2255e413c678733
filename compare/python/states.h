#pragma once

#include <memory>

#include "common/model.h"
#include "common/results.h"
#include "common/solver.h"

namespace concord::compare::python {

/// What a solver says of one state.
struct Evaluated {
  Evaluation evaluation;
  std::shared_ptr<RankReport> rank;  // null where it was not asked for
};

/// Throws InputError unless the state has the bodies, modes and joints of the model, and finite numbers.
void check_state(const Model& model, const State& state);

}  // namespace concord::compare::python
