#pragma once

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

/// Numbers on a command line.
namespace concord::compare {

/// What follows a plus that stands before a digit or a point; std::from_chars takes none.
inline std::string_view without_plus(std::string_view text) {
  const bool is_signed = text.size() > 1 && text[0] == '+' && (text[1] == '.' || (text[1] >= '0' && text[1] <= '9'));
  return is_signed ? text.substr(1) : text;
}

/// The number that is all of `text`, or nothing.
template <class Number>
std::optional<Number> whole_text_as(std::string_view text) {
  text = without_plus(text);
  Number number{};
  const auto [end, trouble] = std::from_chars(text.data(), text.data() + text.size(), number);
  return trouble == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

/// Nothing if `text` is a whole number from 0 to 2^64 - 1, else what is wrong with it. The library that reads the
/// command line takes -1 for the largest number, and what is too large, too.
inline std::string why_no_whole_number(const std::string& text) {
  if (whole_text_as<std::uint64_t>(text)) return {};
  return fmt::format("must be a whole number from 0 to {}, found '{}'", std::numeric_limits<std::uint64_t>::max(),
                     text);
}

/// Nothing if `text` is a whole number within these limits, else what is wrong with it.
inline std::string why_no_count(const std::string& text, std::int64_t least, std::int64_t most) {
  const auto number = whole_text_as<std::int64_t>(text);
  if (number && *number >= least && *number <= most) return "";
  return fmt::format("expected a whole number from {} to {}, found '{}'", least, most, text);
}

/// Nothing if `text` is a number within these limits, which NaN is not, though the library that reads the command line
/// takes it for one; else what is wrong with it.
inline std::string why_not_within(const std::string& text, double least, double most) {
  const auto number = whole_text_as<double>(text);
  if (number && *number >= least && *number <= most) return "";
  return fmt::format("expected a number from {:g} to {:g}, found '{}'", least, most, text);
}

}  // namespace concord::compare
