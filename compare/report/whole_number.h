#pragma once

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <limits>
#include <string>

/// Numbers on a command line.
namespace concord::compare {

/// Nothing if `text` is a whole number from 0 to 2^64 - 1, else what is wrong with it. The library that reads the
/// command line takes -1 for the largest number, and what is too large, too.
inline std::string why_no_whole_number(const std::string& text) {
  std::uint64_t number = 0;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  if (read.ec == std::errc() && read.ptr == end) return {};
  return fmt::format("must be a whole number from 0 to {}, found '{}'", std::numeric_limits<std::uint64_t>::max(),
                     text);
}

/// Nothing if `text` is a number within these limits, which NaN is not, though the library that reads the command line
/// takes it for one; else what is wrong with it.
inline std::string why_not_within(const std::string& text, double least, double most) {
  double number = 0.0;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  if (read.ec == std::errc() && read.ptr == end && number >= least && number <= most) return "";
  return fmt::format("expected a number from {:g} to {:g}, found '{}'", least, most, text);
}

}  // namespace concord::compare
