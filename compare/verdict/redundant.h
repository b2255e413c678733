#pragma once

#include <string>
#include <vector>

#include "compare/resolution/weighed_states.h"
#include "compare/verdict/verdict.h"

/// What of the joints' reactions is determined where constraints are redundant.
namespace concord::compare {

/// What redundant constraints leave of the joints' reactions, from states that were weighed: sums over joints of a pair
/// of bodies, vectors that are unique but for a direction, planar loops, cures. A sum or a vector that differs is a
/// finding if nothing else is.
void judge_redundant(const QuantityLayout& layout, const WeighedStates& weighed, const std::vector<Measured>& measured,
                     Verdict& verdict);

/// The digits that a vector needs in the same state: the fewest that its components need.
double need_of(const Verdict& verdict, const PartlyUnique& part);

/// "joint A on bob, F but for its part along (0.6, 0, 0.8) of bob"; where two directions are left out, "F only along"
/// the third one.
std::string describe(const Model& model, const PartlyUnique& part);

}  // namespace concord::compare
