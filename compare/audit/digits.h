#pragma once

#include <string>

/// Agreement measured in matching digits.
namespace concord::compare {

/// No comparison of doubles can claim more.
inline constexpr double kMostDigits = 16.0;

/// -log10(difference / scale), between 0 and 16. No difference is 16 digits whatever the scale; a difference that is
/// not finite is 0 digits.
double matching_digits(double difference, double scale);

/// The digits to one decimal, rounded down: what is printed never claims more than what is.
std::string format_digits(double digits);

}  // namespace concord::compare
