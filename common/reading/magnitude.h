#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/model.h"

/// Sizes that numbers of a statement may have, so that the products of them that the solvers form neither overflow nor
/// vanish in double precision.
namespace concord {

inline constexpr double kLargestSize = 1e150;
inline constexpr double kSmallestSize = 1e-150;

/// Whether a number is zero, or finite and of a size from kSmallestSize to kLargestSize.
inline bool has_usable_size(double value) {
  const double size = std::abs(value);
  return size == 0.0 || (size >= kSmallestSize && size <= kLargestSize);
}

/// "must be zero or of a size from 1e-150 to 1e+150, found 3e+200": goes on after what the number is called.
std::string complaint_about_size(double value);

/// Half of the last digit of a number as it is written: 5e-5 of "0.0333", 50 of "2.0e3".
double rounding_of(const std::string& text);

/// Whether all entries of a result are finite and at most kLargestSize; round-off may leave any small number.
inline bool are_bounded(const MatX& matrix) { return (matrix.array().abs() <= kLargestSize).all(); }

/// Whether a law of time and its first two derivatives are at most kLargestSize while 0 <= t <= until [s].
bool stays_usable(const TimeFunction& law, double until);

/// One complaint, where the body, joint or force element stands, for each product of the statement's numbers that has
/// no usable size: moments of inertia, energies, forces and accelerations of a machine of that length, speed and
/// weight.
std::vector<Diagnostic> complaints_about_products(const Model& model);

}  // namespace concord
