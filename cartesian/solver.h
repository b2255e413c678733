#pragma once

#include <memory>

#include "common/solver.h"

namespace concord::cartesian {

/// The solver in Cartesian coordinates, Euler parameters and Lagrange multipliers, bound to `model`, which must outlive
/// it.
std::unique_ptr<Solver> make_solver(const Model& model);

}  // namespace concord::cartesian
