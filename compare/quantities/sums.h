#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/results.h"
#include "compare/quantities/agreement.h"

namespace concord::compare {

struct SharedState;

/// A pair of bodies joined by more than one joint: the joints' total wrench on the child of the first one, at its
/// point, in global axes, at t = 0.
struct PairSum {
  std::string what;
  int body = 0;  // on which it acts
  std::array<Wrench, 2> at_start;
  int samples = 0;                   // states in which it must be unique, and is judged
  double digits = 16.0;              // of the largest difference
  double unexplained_digits = 16.0;  // of the largest that round-off does not explain: this is judged
  [[nodiscard]] bool holds(double need) const { return unexplained_digits >= need; }
};

/// For each pair of bodies joined by more than one joint: the joints' total wrench on the child of the first one, moved
/// to the first one's point, in global axes. It is judged in the states where it must be unique, because on one of the
/// two bodies no other joint leaves its own total open; there it is resolved as what makes it so: the sum of all joints
/// on that body, and the totals of the others. `measured` has an entry for each quantity of the layout.
std::vector<PairSum> compare_pair_sums(const QuantityLayout& layout, const std::vector<SharedState>& states,
                                       const std::vector<Measured>& measured, const Budget& budget = {});

}  // namespace concord::compare
