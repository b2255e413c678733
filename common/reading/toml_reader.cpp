#include "common/reading/toml_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <numbers>
#include <utility>

#include "common/reading/magnitude.h"
#include "common/reading/spelling.h"
#include "common/reading/toml_document.h"

namespace concord {

namespace {

std::string quoted(const KnownKeys& keys, std::string_view last_separator) {
  std::string text;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (k > 0) text += k + 1 == keys.size() ? last_separator : ", ";
    text += fmt::format("'{}'", keys[k]);
  }
  return text;
}

/// Each key once: those of several kinds of joints stand in the list of each kind.
std::vector<std::string> distinct(const KnownKeys& keys) {
  std::vector<std::string> names;
  for (const auto& key : keys) {
    if (std::find(names.begin(), names.end(), key) == names.end()) names.emplace_back(key);
  }
  return names;
}

}  // namespace

TableReader::TableReader(const toml::table& table, std::string title, const KnownKeys& known, FileReading& reading)
    : table_(&table), title_(std::move(title)), reading_(&reading) {
  for (const auto& [key, value] : table) {
    if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
    complain_at(reading_->at(key.source()),
                fmt::format("unknown key '{}': {}", key.str(), help_with_word(key.str(), distinct(known), "keys")));
  }
}

bool TableReader::has(std::string_view key) const { return table_->contains(key); }

SourceLocation TableReader::where(std::string_view key) const {
  const toml::node* value = key.empty() ? nullptr : node(key);
  return reading_->at(value != nullptr ? value->source() : table_->source());
}

const toml::node* TableReader::node(std::string_view key) const { return table_->get(key); }

bool TableReader::require(const KnownKeys& keys) const {
  bool complete = true;
  for (const std::string_view key : keys) {
    if (has(key)) continue;
    complain(fmt::format("missing key '{}'", key));
    complete = false;
  }
  return complete;
}

bool TableReader::require_one_of(const KnownKeys& keys) const {
  KnownKeys found;
  std::copy_if(keys.begin(), keys.end(), std::back_inserter(found), [this](std::string_view key) { return has(key); });
  if (found.size() == 1) return true;
  if (found.empty()) {
    complain(fmt::format("missing key: one of {} must be there", quoted(keys, " or ")));
  } else {
    complain(found.back(), fmt::format("{} exclude each other: give one of them", quoted(found, " and ")));
  }
  return false;
}

std::optional<double> TableReader::number_of(const toml::node& node, const std::string& name) const {
  const SourceLocation where = reading_->at(node.source());
  std::optional<double> value;
  if (node.is_string()) {
    try {
      value = reading_->parameters.evaluate(**node.as_string());
    } catch (const ExpressionError& error) {
      if (*error.what() != '\0') complain_at(where, fmt::format("{}: {}", name, error.what()));
      return std::nullopt;
    }
  } else {
    if (node.is_number()) value = number_in(node);
  }
  if (!value) {
    complain_at(where, fmt::format("{} must be a number or an expression, found {}", name, type_name(node)));
  } else if (!std::isfinite(*value)) {
    complain_at(where, fmt::format("{} must be a finite number, found {}", name, not_finite_text(*value)));
    value.reset();
  } else if (!has_usable_size(*value)) {
    complain_at(where, fmt::format("{} {}", name, complaint_about_size(*value)));
    value.reset();
  }
  return value;
}

std::optional<std::vector<double>> TableReader::numbers_of(const toml::node& node, const std::string& name,
                                                           int length) const {
  const SourceLocation where = reading_->at(node.source());
  const toml::array* list = node.as_array();
  if (list == nullptr) {
    const std::string wanted = length >= 0 ? fmt::format("{} numbers", length) : "numbers";
    complain_at(where, fmt::format("{} must be a list of {}, found {}", name, wanted, type_name(node)));
    return std::nullopt;
  }
  if (length >= 0 && list->size() != static_cast<std::size_t>(length)) {
    complain_at(where, fmt::format("{} must be a list of {} numbers, found {}", name, length, list->size()));
    return std::nullopt;
  }
  std::vector<double> values;
  for (std::size_t k = 0; k < list->size(); ++k) {
    if (const auto value = number_of((*list)[k], fmt::format("entry {} of {}", k + 1, name))) values.push_back(*value);
  }
  if (values.size() != list->size()) return std::nullopt;
  return values;
}

std::optional<double> TableReader::number(std::string_view key) const {
  return has(key) ? number_of(*node(key), fmt::format("'{}'", key)) : std::nullopt;
}

double TableReader::slack_of(std::string_view key) const {
  constexpr double kDegree = std::numbers::pi / 180.0;
  const toml::node& found = *node(key);
  const std::string written = found.is_string() ? **found.as_string() : reading_->word_at(found.source());
  char* end = nullptr;
  static_cast<void>(std::strtod(written.c_str(), &end));
  const std::string digits = written.substr(0, static_cast<std::size_t>(end - written.c_str()));
  std::string unit(end);
  std::erase(unit, ' ');
  const std::size_t point = digits.find('.');
  const bool is_decimal = point != std::string::npos && point + 1 < digits.find_first_of("eE") &&
                          point + 1 < digits.size() && (unit.empty() || unit == "deg");
  if (is_decimal) return rounding_of(digits) * (unit.empty() ? 1.0 : kDegree);
  return kWrittenExactly;
}

std::optional<double> TableReader::positive_number(std::string_view key) const {
  const auto value = number(key);
  if (!value || *value > 0.0) return value;
  complain(key, fmt::format("'{}' must be positive, found {}", key, *value));
  return std::nullopt;
}

std::optional<double> TableReader::number_not_negative(std::string_view key) const {
  const auto value = number(key);
  if (!value || *value >= 0.0) return value;
  complain(key, fmt::format("'{}' must not be negative, found {}", key, *value));
  return std::nullopt;
}

std::optional<int> TableReader::count(std::string_view key, int smallest, int largest) const {
  const auto value = number(key);
  if (!value) return std::nullopt;
  if (*value == std::floor(*value) && *value >= smallest && *value <= largest) return static_cast<int>(*value);
  const std::string at_most = *value > largest ? fmt::format(" and at most {}", largest) : "";
  complain(key, fmt::format("'{}' must be a whole number of at least {}{}, found {}", key, smallest, at_most, *value));
  return std::nullopt;
}

std::optional<std::string> TableReader::text(std::string_view key) const {
  if (!has(key)) return std::nullopt;
  if (auto value = node(key)->value_exact<std::string>()) return value;
  complain(key, fmt::format("'{}' must be a string, found {}", key, type_name(*node(key))));
  return std::nullopt;
}

void TableReader::require_fit_for_files(std::string_view key, const std::string& value) const {
  const auto is_bad = [](char c) { return c == '/' || std::iscntrl(static_cast<unsigned char>(c)) != 0; };
  if (std::none_of(value.begin(), value.end(), is_bad)) return require_short(key, value);
  complain(key,
           fmt::format("'{}' must be one line without '/', for result files are named by it, found {:?}", key, value));
}

void TableReader::require_short(std::string_view key, const std::string& value) const {
  constexpr std::size_t kLongest = 100;
  if (value.size() <= kLongest) return;
  complain(key, fmt::format("'{}' has {} bytes, at most {} are allowed: result files are named by it", key,
                            value.size(), kLongest));
}

std::string TableReader::name() const {
  if (!require({"name"})) return "";
  const auto value = text("name");
  if (value && value->empty()) complain("name", "'name' must not be empty");
  if (value) require_fit_for_files("name", *value);
  if (!value || value->empty()) return "";
  std::string whole = reading_->prefix + *value;
  if (!reading_->prefix.empty()) require_short("name", whole);
  if (whole.front() == ' ' || whole.back() == ' ') {
    complain("name", fmt::format("'name' must not begin or end with a blank, found {:?}", whole));
  }
  return whole;
}

std::optional<bool> TableReader::flag(std::string_view key) const {
  if (!has(key)) return std::nullopt;
  if (const auto value = node(key)->value_exact<bool>()) return value;
  complain(key, fmt::format("'{}' must be true or false, found {}", key, type_name(*node(key))));
  return std::nullopt;
}

std::optional<std::vector<double>> TableReader::numbers(std::string_view key, int length) const {
  return has(key) ? numbers_of(*node(key), fmt::format("'{}'", key), length) : std::nullopt;
}

std::optional<VecX> TableReader::vector(std::string_view key, int length) const {
  const auto values = numbers(key, length);
  if (!values) return std::nullopt;
  return VecX(Eigen::Map<const VecX>(values->data(), length));
}

std::optional<Vec3> TableReader::vector3(std::string_view key) const {
  const auto values = vector(key, 3);
  if (!values) return std::nullopt;
  return Vec3(*values);
}

std::optional<Vec3> TableReader::direction(std::string_view key) const {
  const auto value = vector3(key);
  if (!value) return std::nullopt;
  if (value->norm() > 0.0) return Vec3(value->normalized());
  complain(key, fmt::format("'{}' must point somewhere, found a vector of length zero", key));
  return std::nullopt;
}

std::optional<MatX> TableReader::matrix(std::string_view key, int rows, int columns) const {
  if (!has(key)) return std::nullopt;
  const toml::array* list = node(key)->as_array();
  if (list == nullptr || list->size() != static_cast<std::size_t>(rows)) {
    const std::string found = list == nullptr ? std::string(type_name(*node(key))) : std::to_string(list->size());
    complain(key, fmt::format("'{}' must be a list of {} rows of {} numbers, found {}", key, rows, columns, found));
    return std::nullopt;
  }
  MatX result(rows, columns);
  bool complete = true;
  for (int row = 0; row < rows; ++row) {
    const auto values = numbers_of((*list)[row], fmt::format("row {} of '{}'", row + 1, key), columns);
    complete = complete && values.has_value();
    if (values) result.row(row) = Eigen::Map<const Eigen::RowVectorXd>(values->data(), columns);
  }
  if (!complete) return std::nullopt;
  return result;
}

const toml::table* TableReader::table(std::string_view key) const {
  if (!has(key)) return nullptr;
  if (const toml::table* value = node(key)->as_table()) return value;
  complain(key, fmt::format("'{}' must be a table, found {}", key, type_name(*node(key))));
  return nullptr;
}

std::vector<const toml::table*> TableReader::tables(std::string_view key) const {
  if (!has(key)) return {};
  if (!node(key)->is_array_of_tables()) {
    complain(key, fmt::format("'{0}' must be a list of tables, found {1}: write [[{0}]]", key, type_name(*node(key))));
    return {};
  }
  std::vector<const toml::table*> found;
  for (const toml::node& entry : *node(key)->as_array()) found.push_back(entry.as_table());
  return found;
}

void TableReader::note(std::string_view key, std::string_view message) const {
  reading_->notes.push_back(
      {where(key), title_.empty() ? std::string(message) : fmt::format("{}: {}", title_, message)});
}

void TableReader::complain(std::string_view key, std::string_view message) const { complain_at(where(key), message); }

void TableReader::complain(std::string_view message) const { complain_at(where(), message); }

void TableReader::complain_at(const SourceLocation& where, std::string_view message) const {
  reading_->complain(where, title_.empty() ? std::string(message) : fmt::format("{}: {}", title_, message));
}

void check_format(const TableReader& document, int known) {
  if (!document.require({"format"})) return;
  const auto format = document.number("format");
  if (!format || *format == known) return;
  document.complain("format", fmt::format("'format' must be {}, found {}", known, *format));
}

}  // namespace concord
