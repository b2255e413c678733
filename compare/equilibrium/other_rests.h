#pragma once

#include <array>
#include <string>

#include "common/solver.h"
#include "compare/equilibrium/equilibrium.h"
#include "compare/states/branch.h"

/// Whether a rest that a search found is the one that the statement determines: each solver asks itself.
namespace concord::compare {

/// Constraints of velocities alone, as those of a skate, leave more places to go to than directions: which rest is
/// reached hangs by the way, and so do places along what meets no stiffness. Where a machine with such constraints has
/// moved to its rest, it goes there another way, in shorter steps; throws SolverError if that ends elsewhere.
void refuse_other_rest(const Model& model, Solver& solver, const Equilibrium& found);

/// Whether searches that differ no more than starts do by round-off, or rough derivatives by their errors, or that go
/// in shorter steps, end in another rest than this one, as where a machine comes by a saddle: in words, else empty.
std::string other_rest_of_like_search(const Model& model, Solver& solver, const Equilibrium& found);

/// Where two solvers found different rests: throws SolverError if that is a rest at a kink, or one of several of which
/// the way or round-off chooses, as each solver finds alone.
void refuse_undetermined_rest(const Model& model, const Solvers& solvers, const std::array<Equilibrium, 2>& found);

}  // namespace concord::compare
