#pragma once

#include <optional>
#include <string>
#include <vector>

namespace concord::compare {

/// A Markdown table: columns of one width each, `| a | b |`, under a rule; every line has as many cells as the first.
/// Bars in a text are escaped; control characters become spaces. The columns named in `right` are aligned right.
std::string format_table(const std::vector<std::vector<std::string>>& texts, const std::vector<bool>& right);

/// A table as text or on a page: the first line is its head; which columns stand right.
struct TextTable {
  std::vector<std::vector<std::string>> lines;
  std::vector<bool> right;
};
inline std::string format_table(const TextTable& table) { return format_table(table.lines, table.right); }

/// A text as a cell of such a table, in one line.
std::string as_cell(const std::string& text);

/// "13.4"; "-" where there are none.
std::string digits_cell(const std::optional<double>& digits);
/// "13.4 of 15.1": digits that agree, and of how many that double precision resolves, where that is known.
std::string digits_cell(const std::optional<double>& digits, const std::optional<double>& resolvable);

/// "1 loop", "2 loops".
std::string plural(int count, const char* one, const char* many);

}  // namespace concord::compare
