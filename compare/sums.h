#pragma once

#include <vector>

#include "compare/align.h"
#include "compare/verdict.h"

namespace concord::compare {

/// For each pair of bodies joined by more than one joint: the joints' total wrench on the child of the first one, moved
/// to the first one's point, in global axes; its digits over the states, on the scale of the largest wrench in it.
std::vector<PairSum> compare_pair_sums(const Model& model, const std::vector<SharedState>& states);

}  // namespace concord::compare
