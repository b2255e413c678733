#pragma once

#include <vector>

#include "compare/verdict/agreement.h"
#include "compare/verdict/refinement.h"
#include "compare/verdict/verdict.h"

namespace concord::compare {

/// "joint D on slider, T_z, t = 1.284 s: cartesian +0.0127, relative -0.0127 N m, 0 digits (need 5)".
std::string describe(const Model& model, const Quantity& quantity, const Measured& measured, double need);

/// One finding for each joint, force element or body that fails on a rung, its worst quantity, the largest shortfall
/// first; sums on bodies only if nothing else fails. Quantities that failed on an earlier rung (stands in `known`) is
/// left out, and is added there.
std::vector<Finding> find_differences(const QuantityLayout& layout, const Series& series,
                                      const std::vector<Measured>& measured, const Verdict& verdict, Rung rung,
                                      std::vector<Quantity>& known);

}  // namespace concord::compare
