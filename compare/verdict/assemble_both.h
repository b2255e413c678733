#pragma once

#include <array>
#include <cstdint>

#include "common/solver.h"
#include "compare/verdict/verdict.h"

namespace concord::compare {

/// Both solvers' starts; a state without bodies where one has none. Writes ranks and cut joints of each into the
/// verdict. A start that one solver finds and the other one refuses is bad input, InputError, unless it is the latter
/// that is wrong: then, and where a solver cannot finish, it is a failure of the verdict; so are starts beside a
/// singular pose, where closing knows them no better than they differ. `explains`: what both say of their constraints
/// is asked for, too; `seed` draws the states for it.
std::array<State, 2> assemble_both(const Model& model, const std::array<Solver*, 2>& solvers, std::uint64_t seed,
                                   bool explains, Verdict& verdict);

}  // namespace concord::compare
