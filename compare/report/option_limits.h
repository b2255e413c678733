#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "compare/report/whole_number.h"

namespace concord::compare {

/// For an option that takes whole numbers; its help names the limits.
inline CLI::Validator whole_number_from(std::int64_t least, std::int64_t most) {
  return {[=](std::string& text) { return why_no_count(text, least, most); }, fmt::format("{} to {}", least, most)};
}

}  // namespace concord::compare
