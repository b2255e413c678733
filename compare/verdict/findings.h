#pragma once

#include <vector>

#include "compare/quantities/agreement.h"
#include "compare/verdict/refinement.h"
#include "compare/verdict/verdict.h"

namespace concord::compare {

/// A difference as a line: "joint D on slider, T_z, t = 1.284 s: cartesian +0.0127, relative -0.0127 N m, 0 digits
/// (need 5)". `need` is the number of required digits.
std::string describe(const Model& model, const Quantity& quantity, const Measured& measured, double need);

/// What fails in a check: one finding for each joint, force element or body, with its worst quantity. The findings are
/// sorted by the digits that are missing, most first. Sums on bodies are reported only if nothing else fails.
/// Quantities in `known` failed in an earlier check and are left out; those that fail here are added to it.
std::vector<Finding> find_differences(const QuantityLayout& layout, const Series& series,
                                      const std::vector<Measured>& measured, const Verdict& verdict, Check check,
                                      std::vector<Quantity>& known);

}  // namespace concord::compare
