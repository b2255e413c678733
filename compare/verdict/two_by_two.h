#pragma once

#include <array>
#include <optional>
#include <string>

#include "common/solver.h"
#include "compare/verdict/verdict.h"

/// Does a difference of two runs come from the formulation or from the integration?
namespace concord::compare {

/// Evaluates each solver's algebra on each solver's run at up to kTableSamples common samples, for the row of the
/// verdict that differs most. Nothing if a run is missing, no row differs, or no solver accepts the other one's states.
std::optional<TwoByTwo> two_by_two(const Model& model, const std::array<Solver*, 2>& solvers, const Verdict& verdict);

/// "joint C on coupler, F_y, largest over 41 samples: formulation 3.10e-13 N on cartesian's motion, ...".
std::string describe(const TwoByTwo& table);

}  // namespace concord::compare
