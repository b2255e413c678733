#include "compare/quantities/reference_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "common/error.h"
#include "common/reading/magnitude.h"
#include "common/reading/spelling.h"
#include "common/reading/text_file.h"

namespace concord::compare {

namespace {

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// A field of a line, and where it begins, from 1.
struct CsvField {
  std::string text;
  int column;
};

/// Fields of a line of comma-separated values; quotes as CSV has them. Blanks beside a field count only within quotes.
std::vector<CsvField> fields_of(const std::string& line) {
  std::vector<CsvField> fields{{"", 1}};
  bool quoted = false;
  std::size_t needed = 0;  // of the field: up to the last quote
  const auto finish = [&] {
    std::string& text = fields.back().text;
    const std::size_t last = text.find_last_not_of(" \t\r");
    text.erase(std::max(needed, last == std::string::npos ? 0 : last + 1));
    needed = 0;
  };
  for (std::size_t k = 0; k < line.size(); ++k) {
    std::string& text = fields.back().text;
    if (line[k] == '"') {
      const bool doubled = quoted && k + 1 < line.size() && line[k + 1] == '"';
      if (doubled) text += line[++k];
      if (!doubled) quoted = !quoted;
      needed = text.size();
    } else if (line[k] == ',' && !quoted) {
      finish();
      fields.push_back({"", static_cast<int>(k) + 2});
    } else if (quoted || !text.empty() || line[k] != ' ') {
      text += line[k];
    } else {
      ++fields.back().column;
    }
  }
  finish();
  return fields;
}

/// A number; one that is too small for the sizes of a model is as good as zero here.
std::optional<double> number_in(const std::string& text) {
  double value = 0.0;
  const char* first = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* end = text.data() + text.size();
  const auto [read, trouble] = std::from_chars(first, end, value);
  const bool is_out_of_range = trouble == std::errc::result_out_of_range;
  if (is_out_of_range) value = std::strtod(first, nullptr);  // infinite, or next to nothing
  if ((trouble != std::errc() && !is_out_of_range) || read != end || !(std::abs(value) <= kLargestSize))
    return std::nullopt;
  return value;
}

/// Digits of a number as it is written, without leading zeros: 5 of "-0.10200", 3 of "1.05e-7", none of "0.0".
int digits_of(const std::string& text) {
  const std::string mantissa = text.substr(0, text.find_first_of("eE"));
  const std::size_t first = mantissa.find_first_of("123456789");
  if (first == std::string::npos) return 0;
  return static_cast<int>(std::count_if(mantissa.begin() + static_cast<std::ptrdiff_t>(first), mantissa.end(),
                                        [](unsigned char c) { return std::isdigit(c) != 0; }));
}

/// What of a header is no separator of ours: empty, or a hint at it.
std::string hint_at_separator(const std::string& header) {
  if (header.find(';') != std::string::npos) return ": fields are separated by commas, not by semicolons";
  if (header.find('\t') != std::string::npos) return ": fields are separated by commas, not by tabs";
  return "";
}

/// Every column that a reference may have, by its name: "D.child.T_z".
std::map<std::string, Column> known_columns(const Model& model) {
  std::map<std::string, Column> known;
  for (const auto& columns :
       {reaction_columns(model), element_columns(model), motion_columns(model), further_columns(model)}) {
    for (const Column& column : columns) known.try_emplace(column.name, column);
  }
  const std::map<std::string, Column> of_run = known;
  for (const auto& [name, column] : of_run) {
    if (may_be_open(column)) known.try_emplace(own_column(column).name, own_column(column));
  }
  return known;
}

struct StatedError {
  double size = 0.0;
  bool is_relative = true;
  std::string unit;
  int line = 0;
};

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();  // nothing is said there

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // spreadsheets write it

class ReferenceReader {
 public:
  ReferenceReader(const std::filesystem::path& file, const Model& model) : file_(file), known_(known_columns(model)) {
    reference_.file = file.string();
    for (const Joint& joint : model.joints) joints_.push_back(joint.name);
  }

  Reference read() {
    const std::string content = read_text_file(file_);
    if (content.find('\0') != std::string::npos) refuse("holds a zero byte: expected text in UTF-8");
    std::istringstream stream(content);
    std::string text;
    while (std::getline(stream, text)) {
      ++line_;
      if (line_ == 1 && text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
      text = trimmed(text);
      if (text.empty()) continue;
      if (text.front() == '#') {
        read_comment(trimmed(text.substr(1)));
      } else if (header_line_ == 0) {
        read_header(text);
      } else if (is_long_) {
        keep_long_row(fields_of(text));
      } else {
        read_row(fields_of(text));
      }
    }
    read_long_rows();
    if (reference_.times.empty()) refuse("holds no row: expected a header and at least one line of numbers");
    state_errors();
    return std::move(reference_);
  }

 private:
  [[noreturn]] void refuse(const std::string& message, int column = 1) const { refuse_at(line_, column, message); }
  [[noreturn]] void refuse_at(int line, int column, const std::string& message) const {
    throw InputError({file_.string(), line, line > 0 ? column : 0}, fmt::format("reference: {}", message));
  }

  /// "error = 0.5 %", "error D.child.T_z = 0.02 N m"; any other comment says nothing.
  void read_comment(const std::string& text) {
    constexpr std::string_view kError = "error";
    const std::size_t equals = text.find('=');
    const bool says_error = equals != std::string::npos && text.size() > kError.size() &&
                            std::equal(kError.begin(), kError.end(), text.begin(),
                                       [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
    if (!says_error && equals != std::string::npos) {
      read_convention(trimmed(text.substr(0, equals)), trimmed(text.substr(equals + 1)));
    }
    if (!says_error) return;
    const std::string column = trimmed(text.substr(kError.size(), equals - kError.size()));
    const std::string said = trimmed(text.substr(equals + 1));
    const std::size_t space = said.find_first_of(" %");
    const auto size = number_in(said.substr(0, space));
    const std::string unit = space == std::string::npos ? "" : trimmed(said.substr(space));
    if (!size || !(*size >= 0.0) || unit.empty()) {
      refuse(
          fmt::format("'{}': expected a stated error such as `error = 0.5 %` or `error D.child.T_z = 0.02 N m`", text));
    }
    if (column.empty() && unit != "%") {
      refuse(
          fmt::format("the error of all columns is in %, found '{}'; one in a unit names its column: `error "
                      "D.child.T_z = 0.02 N m`",
                      said));
    }
    const StatedError stated{unit == "%" ? *size / 100.0 : *size, unit == "%", unit, line_};
    const auto [found, is_new] = errors_.try_emplace(column, stated);
    if (is_new) return;
    refuse(fmt::format("the error of {} is stated in line {} already",
                       column.empty() ? "all columns" : fmt::format("'{}'", column), found->second.line));
  }

  /// "side", "parent" of "# side = parent", or "side D", "parent"; any other comment says nothing.
  void read_convention(const std::string& said, const std::string& value) {
    const std::string word = said.substr(0, said.find(' '));
    const std::string joint = trimmed(said.substr(word.size()));
    if (!is_convention_word(word)) return;
    if (!joint.empty() && std::find(joints_.begin(), joints_.end(), joint) == joints_.end()) {
      refuse(fmt::format("a convention is stated for '{}', which is no joint", joint));
    }
    Convention& convention = reference_.conventions[joint];
    if (!say(word, value, convention)) {
      refuse(fmt::format("'{} = {}': expected {}", said, value, words_of_conventions()));
    }
    if (!conventions_.insert(said).second) refuse(fmt::format("'{}' is stated already", said));
  }

  void read_header(const std::string& text) {
    const std::vector<CsvField> names = fields_of(text);
    header_line_ = line_;
    const std::vector<std::string> expected{"t", "of", "component", "value"};
    is_long_ = std::equal(names.begin(), names.end(), expected.begin(), expected.end(),
                          [](const CsvField& name, const std::string& other) { return name.text == other; });
    if (is_long_) return;
    if (names.front().text != "t [s]") {
      refuse(fmt::format("the first column is '{}', expected 't [s]'{}", names.front().text, hint_at_separator(text)));
    }
    for (std::size_t k = 1; k < names.size(); ++k) {
      reference_.columns.push_back(column_named(names[k]));
      const std::string& name = reference_.columns.back().column.name;
      const auto is_it = [&](const ReferenceColumn& column) { return column.column.name == name; };
      if (std::count_if(reference_.columns.begin(), reference_.columns.end(), is_it) > 1) {
        refuse(fmt::format("column '{}' stands there twice", name), names[k].column);
      }
    }
    if (reference_.columns.empty()) {
      refuse(fmt::format("the header names no component beside the time{}", hint_at_separator(text)));
    }
  }

  [[nodiscard]] ReferenceColumn column_named(const CsvField& header) const {
    const std::size_t bracket = header.text.rfind('[');
    std::string name = header.text.substr(0, bracket);
    name.erase(name.find_last_not_of(' ') + 1);
    const auto found = known_.find(name);
    if (found == known_.end()) {
      std::vector<std::string> names;
      for (const auto& [one, column] : known_) names.push_back(one);
      const std::string hint = suggestion(name, names, "columns");
      refuse(fmt::format("the model has no '{}'{} Columns are called JOINT.child.F_x [N] ... JOINT.parent.T_z [N m], "
                         "and as in all our result files",
                         name, hint.starts_with("did") ? ": " + hint : "."),
             header.column);
    }
    const std::string unit = fmt::format("[{}]", found->second.unit);
    if (bracket == std::string::npos || header.text.substr(bracket) != unit) {
      refuse(fmt::format("column '{}': its unit must stand behind it: {}", header.text, unit), header.column);
    }
    ReferenceColumn column;
    column.column = found->second;
    return column;
  }

  /// The number in a field: NaN where it says nothing.
  [[nodiscard]] double value_in(const CsvField& field) const {
    if (field.text == "nan") return kNothing;
    return said_in(field);
  }

  [[nodiscard]] double said_in(const CsvField& field) const {
    const auto value = number_in(field.text);
    if (!value)
      refuse(fmt::format("'{}' is not a number of a size up to {:g}", field.text, kLargestSize), field.column);
    return *value;
  }

  /// A new time, and nothing said there yet.
  void add_time(const CsvField& field) {
    const double t = said_in(field);
    if (!reference_.times.empty() && t <= reference_.times.back()) {
      refuse(fmt::format("t = {:g} s does not follow {:g} s: times must rise", t, reference_.times.back()));
    }
    reference_.times.push_back(t);
    reference_.time_roundings.push_back(rounding_of(field.text));
    reference_.lines.push_back(line_);
    for (ReferenceColumn& column : reference_.columns) column.values.push_back(kNothing);
  }

  static void enter(const CsvField& field, double value, ReferenceColumn& column) {
    column.values.back() = value;
    column.digits = std::max(column.digits, digits_of(field.text));
  }

  /// The column of "D", "F_x" in the long format: D.F_x if there is one, else, on the child's side, D.child.F_x.
  ReferenceColumn& column_of(const CsvField& of, const CsvField& component) {
    std::string name = fmt::format("{}.{}", of.text, component.text);
    const std::string on_child = fmt::format("{}.child.{}", of.text, component.text);
    if (!known_.contains(name) && known_.contains(on_child)) name = on_child;
    const auto is_it = [&](const ReferenceColumn& column) { return column.column.name == name; };
    const auto found = std::find_if(reference_.columns.begin(), reference_.columns.end(), is_it);
    if (found != reference_.columns.end()) return *found;
    const auto known = known_.find(name);
    const std::string unit = known == known_.end() ? "" : fmt::format(" [{}]", known->second.unit);
    reference_.columns.push_back(column_named({name + unit, of.column}));
    reference_.columns.back().values.assign(reference_.times.size(), kNothing);
    return reference_.columns.back();
  }

  struct LongRow {
    double t;
    int line;
    std::vector<CsvField> fields;
  };

  void keep_long_row(const std::vector<CsvField>& fields) {
    if (fields.size() != 4) refuse(fmt::format("{} fields, expected 4: t,of,component,value", fields.size()));
    long_rows_.push_back({said_in(fields[0]), line_, fields});
  }

  /// Lines may stand in any order: by joint, by component, or by time.
  void read_long_rows() {
    std::stable_sort(long_rows_.begin(), long_rows_.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
    for (const LongRow& row : long_rows_) {
      line_ = row.line;
      read_long_row(row.fields);
    }
  }

  /// "0.05,D,F_x,12.1", in the order of time.
  void read_long_row(const std::vector<CsvField>& fields) {
    if (reference_.times.empty() || said_in(fields[0]) != reference_.times.back()) add_time(fields[0]);
    ReferenceColumn& column = column_of(fields[1], fields[2]);
    if (!std::isnan(column.values.back())) {
      refuse(fmt::format("column '{}' stands there twice at t = {:g} s", column.column.name, reference_.times.back()),
             fields[1].column);
    }
    enter(fields[3], value_in(fields[3]), column);
  }

  void read_row(const std::vector<CsvField>& fields) {
    if (fields.size() != reference_.columns.size() + 1) {
      refuse(fmt::format("{} numbers, the header has {}", fields.size(), reference_.columns.size() + 1));
    }
    add_time(fields.front());
    for (std::size_t k = 1; k < fields.size(); ++k) enter(fields[k], value_in(fields[k]), reference_.columns[k - 1]);
  }

  void state_errors() {
    for (const auto& [name, error] : errors_) {
      const auto is_it = [&, &wanted = name](const ReferenceColumn& column) { return column.column.name == wanted; };
      if (name.empty() || std::any_of(reference_.columns.begin(), reference_.columns.end(), is_it)) continue;
      refuse_at(error.line, 1, fmt::format("an error is stated for '{}', which is no column", name));
    }
    for (ReferenceColumn& column : reference_.columns) {
      auto found = errors_.find(column.column.name);
      if (found == errors_.end()) found = errors_.find("");
      column.is_stated = found != errors_.end();
      if (!column.is_stated) continue;  // it follows from the digits
      const StatedError& stated = found->second;
      if (!stated.is_relative && stated.unit != column.column.unit) {
        refuse_at(stated.line, 1,
                  fmt::format("the error of '{}' is in {}, the column in {}", column.column.name, stated.unit,
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
  std::vector<std::string> joints_;
  std::set<std::string> conventions_;  // that are stated: "side", "side D"
  std::vector<LongRow> long_rows_;
  bool is_long_ = false;  // one line a number
  int header_line_ = 0;
  int line_ = 0;
};

}  // namespace

Reference read_reference(const std::filesystem::path& file, const Model& model) {
  return ReferenceReader(file, model).read();
}

}  // namespace concord::compare
