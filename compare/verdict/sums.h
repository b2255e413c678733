#pragma once

#include <vector>

#include "compare/verdict/agreement.h"
#include "compare/verdict/verdict.h"
#include "compare/verdict/weighed_states.h"

namespace concord::compare {

/// For each pair of bodies joined by more than one joint: the joints' total wrench on the child of the first one, moved
/// to the first one's point, in global axes. It is judged in the states where it must be unique, because on one of the
/// two bodies no other joint leaves its own total open; there it is resolved as what makes it so: the sum of all joints
/// on that body, and the totals of the others. `measured` has an entry for each quantity of the layout.
std::vector<PairSum> compare_pair_sums(const QuantityLayout& layout, const std::vector<SharedState>& states,
                                       const std::vector<Measured>& measured, const Budget& budget = {});

/// Puts those of states that were weighed into the verdict; one that differs is a finding if nothing else is.
void judge_pair_sums(const QuantityLayout& layout, const WeighedStates& weighed, const std::vector<Measured>& measured,
                     Verdict& verdict);

}  // namespace concord::compare
