#pragma once

#include <memory>

#include "common/solver.h"

namespace concord::relative {

/// The relative-coordinate solver (velocity transformation, THEORY.md) for a model, of which it keeps a
/// copy. Throws InputError if the loops cannot be opened as the model says.
std::unique_ptr<Solver> make_solver(const Model& model);

}  // namespace concord::relative
