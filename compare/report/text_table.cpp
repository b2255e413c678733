#include "compare/report/text_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "compare/audit/digits.h"

namespace concord::compare {

std::string as_cell(const std::string& text) {
  std::string cell;
  for (const char c : text) {
    if (c == '|') cell += '\\';
    cell += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return cell;
}

std::string format_table(const std::vector<std::vector<std::string>>& texts, const std::vector<bool>& right) {
  std::vector<std::vector<std::string>> lines = texts;
  for (auto& line : lines) std::transform(line.begin(), line.end(), line.begin(), as_cell);
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

std::string digits_cell(const std::optional<double>& digits) { return digits ? format_digits(*digits) : "-"; }

std::string digits_cell(const std::optional<double>& digits, const std::optional<double>& resolvable) {
  return digits_cell(digits) + (resolvable ? " of " + format_digits(*resolvable) : "");
}

std::string plural(int count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

}  // namespace concord::compare
