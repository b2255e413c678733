#pragma once

#include <functional>
#include <memory>

#include "common/solver.h"

namespace concord::compare {

/// Makes a solver of each kind for a model.
struct SolverMakers {
  std::function<std::unique_ptr<Solver>(const Model&)> cartesian;
  std::function<std::unique_ptr<Solver>(const Model&)> relative;
};

}  // namespace concord::compare
