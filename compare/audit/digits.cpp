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

std::string format_percent(double part, int decimals) {
  constexpr double kMost = 10.0;
  if (part > kMost) return fmt::format("more than {:+g} %", 100.0 * kMost);
  if (part < -kMost) return fmt::format("less than {:+g} %", -100.0 * kMost);
  return fmt::format("{:+.{}f} %", 100.0 * part, decimals);
}

}  // namespace concord::compare
