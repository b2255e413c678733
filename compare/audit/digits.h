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

/// A change of a quantity, or what is added to it, as a part of it, in percent and signed: "+5.5 %". Beyond ten times
/// the quantity itself the number says nothing more: "more than +1000 %", "less than -1000 %".
std::string format_percent(double part, int decimals);

}  // namespace concord::compare
