#include "compare/verdict/reference_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include "common/error.h"
#include "common/reading/magnitude.h"
#include "common/reading/text_file.h"

namespace concord::compare {

namespace {

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Fields of a line of comma-separated values; quotes as CSV has them.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t k = 0; k < line.size(); ++k) {
    if (line[k] == '"') {
      const bool doubled = quoted && k + 1 < line.size() && line[k + 1] == '"';
      if (doubled) fields.back() += line[++k];
      if (!doubled) quoted = !quoted;
    } else if (line[k] == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += line[k];
    }
  }
  for (std::string& field : fields) field = trimmed(field);
  return fields;
}

std::optional<double> number_in(const std::string& text) {
  double value = 0.0;
  const char* first = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* end = text.data() + text.size();
  const auto [read, trouble] = std::from_chars(first, end, value);
  if (trouble != std::errc() || read != end || !has_usable_size(value)) return std::nullopt;
  return value;
}

/// Every column that a reference may have, by its name: "D.child.T_z".
std::map<std::string, Column> known_columns(const Model& model) {
  std::map<std::string, Column> known;
  for (const auto& columns :
       {reaction_columns(model), element_columns(model), motion_columns(model), further_columns(model)}) {
    for (const Column& column : columns) known.try_emplace(column.name, column);
  }
  return known;
}

struct StatedError {
  double size = 0.0;
  bool is_relative = true;
  std::string unit;
};

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // spreadsheets write it

class ReferenceReader {
 public:
  ReferenceReader(const std::filesystem::path& file, const Model& model) : file_(file), known_(known_columns(model)) {
    reference_.file = file.string();
  }

  Reference read() {
    std::istringstream stream(read_text_file(file_));
    std::string text;
    while (std::getline(stream, text)) {
      ++line_;
      if (line_ == 1 && text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
      text = trimmed(text);
      if (text.empty()) continue;
      if (text.front() == '#') {
        read_comment(trimmed(text.substr(1)));
      } else if (!has_header_) {
        read_header(fields_of(text));
      } else {
        read_row(fields_of(text));
      }
    }
    if (reference_.times.empty()) refuse("holds no row: expected a header and at least one line of numbers");
    state_errors();
    return std::move(reference_);
  }

 private:
  [[noreturn]] void refuse(const std::string& message) const {
    throw InputError({file_.string(), line_, line_ > 0 ? 1 : 0}, fmt::format("reference: {}", message));
  }

  /// "error = 0.5 %", "error D.child.T_z = 0.02 N m"; any other comment says nothing.
  void read_comment(const std::string& text) {
    const std::size_t equals = text.find('=');
    if (!text.starts_with("error") || equals == std::string::npos) return;
    const std::string column = trimmed(text.substr(5, equals - 5));
    const std::string said = trimmed(text.substr(equals + 1));
    const std::size_t space = said.find_first_of(" %");
    const auto size = number_in(said.substr(0, space));
    const std::string unit = space == std::string::npos ? "" : trimmed(said.substr(space));
    if (!size || !(*size >= 0.0) || unit.empty()) {
      refuse(
          fmt::format("'{}': expected a stated error such as `error = 0.5 %` or `error D.child.T_z = 0.02 N m`", text));
    }
    if (column.empty() && unit != "%") refuse("an error of all columns must be in %, because their units differ");
    errors_[column] = {unit == "%" ? *size / 100.0 : *size, unit == "%", unit};
  }

  void read_header(const std::vector<std::string>& names) {
    has_header_ = true;
    if (names.front() != "t [s]") refuse(fmt::format("the first column is '{}', expected 't [s]'", names.front()));
    for (std::size_t k = 1; k < names.size(); ++k) {
      reference_.columns.push_back(column_named(names[k]));
      const std::string& name = reference_.columns.back().column.name;
      const auto is_it = [&](const ReferenceColumn& column) { return column.column.name == name; };
      if (std::count_if(reference_.columns.begin(), reference_.columns.end(), is_it) > 1) {
        refuse(fmt::format("column '{}' stands there twice", name));
      }
    }
    if (reference_.columns.empty()) refuse("the header names no component beside the time");
  }

  [[nodiscard]] ReferenceColumn column_named(const std::string& header) const {
    const std::size_t bracket = header.rfind('[');
    const std::string name = trimmed(header.substr(0, bracket));
    const auto found = known_.find(name);
    if (found == known_.end()) {
      refuse(fmt::format(
          "the model has no '{}'; columns are called JOINT.child.F_x [N] ... JOINT.parent.T_z [N m], and as "
          "in all our result files",
          name));
    }
    const std::string unit = fmt::format("[{}]", found->second.unit);
    if (bracket == std::string::npos || header.substr(bracket) != unit) {
      refuse(fmt::format("column '{}': its unit must stand behind it: {}", header, unit));
    }
    ReferenceColumn column;
    column.column = found->second;
    return column;
  }

  void read_row(const std::vector<std::string>& fields) {
    if (fields.size() != reference_.columns.size() + 1) {
      refuse(fmt::format("{} numbers, the header has {}", fields.size(), reference_.columns.size() + 1));
    }
    std::vector<double> numbers;
    for (const std::string& field : fields) {
      const auto value = number_in(field);
      if (!value) refuse(fmt::format("'{}' is not a number", field));
      numbers.push_back(*value);
    }
    if (!reference_.times.empty() && numbers.front() <= reference_.times.back()) {
      refuse(
          fmt::format("t = {:g} s does not follow {:g} s: times must rise", numbers.front(), reference_.times.back()));
    }
    reference_.times.push_back(numbers.front());
    reference_.lines.push_back(line_);
    for (std::size_t k = 1; k < numbers.size(); ++k) reference_.columns[k - 1].values.push_back(numbers[k]);
  }

  void state_errors() {
    for (const auto& [name, error] : errors_) {
      const auto is_it = [&, &wanted = name](const ReferenceColumn& column) { return column.column.name == wanted; };
      if (name.empty() || std::any_of(reference_.columns.begin(), reference_.columns.end(), is_it)) continue;
      refuse(fmt::format("an error is stated for '{}', which is no column", name));
    }
    for (ReferenceColumn& column : reference_.columns) {
      auto found = errors_.find(column.column.name);
      if (found == errors_.end()) found = errors_.find("");
      if (found == errors_.end()) {
        refuse(fmt::format("'{}' has no stated error: say how far the source may be off, such as `# error = 1 %`",
                           column.column.name));
      }
      const StatedError& stated = found->second;
      if (!stated.is_relative && stated.unit != column.column.unit) {
        refuse(fmt::format("the error of '{}' is in {}, the column in {}", column.column.name, stated.unit,
                           column.column.unit));
      }
      column.error = stated.size;
      column.is_relative = stated.is_relative;
    }
  }

  std::filesystem::path file_;
  std::map<std::string, Column> known_;
  std::map<std::string, StatedError> errors_;
  Reference reference_;
  bool has_header_ = false;
  int line_ = 0;
};

}  // namespace

Reference read_reference(const std::filesystem::path& file, const Model& model) {
  return ReferenceReader(file, model).read();
}

}  // namespace concord::compare
