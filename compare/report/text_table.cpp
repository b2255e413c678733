#include "compare/report/text_table.h"

#include <fmt/format.h>

#include <algorithm>

namespace concord::compare {

std::string format_table(const std::vector<std::vector<std::string>>& lines, const std::vector<bool>& right) {
  std::vector<std::size_t> widths(right.size(), 0);
  for (const auto& line : lines) {
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  }
  std::string text;
  for (std::size_t row = 0; row < lines.size(); ++row) {
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const std::string& cell = lines[row][c];
      text += right[c] ? fmt::format("| {:>{}} ", cell, widths[c]) : fmt::format("| {:<{}} ", cell, widths[c]);
    }
    text += "|\n";
    if (row > 0) continue;
    for (std::size_t c = 0; c < widths.size(); ++c) {
      text += fmt::format("|{:-<{}}{}", "", widths[c] + 1, right[c] ? ":" : "-");
    }
    text += "|\n";
  }
  return text;
}

std::string plural(int count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

}  // namespace concord::compare
