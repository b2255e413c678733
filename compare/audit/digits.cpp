#include "compare/audit/digits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace concord::compare {

double matching_digits(double difference, double scale) {
  if (difference == 0.0) return kMostDigits;
  if (!std::isfinite(difference) || !(scale > 0.0)) return 0.0;
  return std::clamp(0.0 - std::log10(std::abs(difference) / scale), 0.0, kMostDigits);  // never -0
}

std::string format_digits(double digits) { return fmt::format("{:.1f}", std::floor(digits * 10.0) / 10.0); }

}  // namespace concord::compare
