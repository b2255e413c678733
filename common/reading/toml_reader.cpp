#include "common/reading/toml_reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <iterator>

#include "common/reading/magnitude.h"
#include "common/reading/spelling.h"

namespace concord {

namespace {

bool in_order(const SourceLocation& a, const SourceLocation& b) {
  return a.line != b.line ? a.line < b.line : a.column < b.column;
}

std::string quoted(const KnownKeys& keys, std::string_view last_separator) {
  std::string text;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (k > 0) text += k + 1 == keys.size() ? last_separator : ", ";
    text += fmt::format("'{}'", keys[k]);
  }
  return text;
}

/// More complaints than this are not reported.
constexpr std::size_t kMostComplaints = 200;

/// Looks through a document before it is parsed: the parser builds and takes down nested values by recursion.
class NestingCheck {
 public:
  NestingCheck(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  void run() {
    while (place_ < text_.size()) {
      const char c = text_[place_];
      if (c == '#') {
        skip_to("\n");
      } else if (c == '"' || c == '\'') {
        skip_string(c);
      } else {
        look_at(c);
        step();
      }
    }
  }

 private:
  static constexpr std::size_t kDeepest = 100;
  static constexpr std::size_t kMostValues = 4000000;

  /// Every dot of a key nests a table, every bracket a value. Numbers have a dot too, which does no harm.
  void look_at(char c) {
    switch (c) {
      case '.':
        ++levels_.back();
        break;
      case '[':
      case '{':
        levels_.push_back(levels_.back() + 1);
        ++values_;
        break;
      case ']':
      case '}':
        if (levels_.size() > 1) levels_.pop_back();
        break;
      case ',':
      case '\n':
        levels_.back() = levels_.size() > 1 ? levels_[levels_.size() - 2] + 1 : 0;
        ++values_;
        break;
      default:
        break;
    }
    if (levels_.back() > kDeepest) refuse(fmt::format("nested deeper than {} levels", kDeepest));
    if (values_ > kMostValues) refuse(fmt::format("more than {} values in one file", kMostValues));
  }

  void step() {
    if (text_[place_] == '\n') {
      ++line_;
      column_ = 1;
    } else if ((static_cast<unsigned char>(text_[place_]) & 0xC0U) != 0x80U) {
      ++column_;  // not within a character of several bytes
    }
    ++place_;
  }

  void skip_to(std::string_view end) {
    while (place_ < text_.size() && !text_.substr(place_).starts_with(end)) step();
  }

  void skip_string(char quote) {
    const std::string three(3, quote);
    const bool is_long = text_.substr(place_).starts_with(three);
    const std::string_view end = is_long ? std::string_view(three) : std::string_view(three).substr(0, 1);
    for (std::size_t k = 0; k < end.size(); ++k) step();
    while (place_ < text_.size() && !text_.substr(place_).starts_with(end)) {
      if (!is_long && text_[place_] == '\n') return;  // not closed: the parser will say so
      if (quote == '"' && text_[place_] == '\\' && place_ + 1 < text_.size()) step();
      step();
    }
    // A long string may end with up to two quotes of its own before the three that close it.
    const std::size_t most = is_long ? 5 : 1;
    for (std::size_t k = 0; k < most && place_ < text_.size() && text_[place_] == quote; ++k) step();
  }

  [[noreturn]] void refuse(const std::string& reason) const {
    throw InputError(SourceLocation{file_, line_, column_}, reason + ": no model needs that");
  }

  std::string_view text_;
  const std::string& file_;
  std::size_t place_ = 0;
  int line_ = 1;
  int column_ = 1;
  std::vector<std::size_t> levels_{0};  // reached at each open bracket
  std::size_t values_ = 0;
};

std::string_view kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a fifo";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

/// An open file, closed at the end.
class OpenFile {
 public:
  /// Does not wait for somebody to write into a fifo.
  explicit OpenFile(const std::filesystem::path& path)
      : file_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {}
  ~OpenFile() {
    if (file_ >= 0) ::close(file_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  [[nodiscard]] bool is_open() const { return file_ >= 0; }
  [[nodiscard]] mode_t mode() const {
    struct stat found {};
    return ::fstat(file_, &found) == 0 ? found.st_mode : 0;
  }

  /// Appends the next bytes to `text`; 0 at the end, negative if the system refuses.
  ssize_t read_more(std::string& text) {
    std::array<char, 65536> bytes;
    ssize_t count = 0;
    do {
      count = ::read(file_, bytes.data(), bytes.size());
    } while (count < 0 && errno == EINTR);
    if (count > 0) text.append(bytes.data(), static_cast<std::size_t>(count));
    return count;
  }

 private:
  int file_;
};

}  // namespace

SourceLocation FileReading::at(const toml::source_region& region) const {
  return {file, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

void FileReading::complain(const SourceLocation& where, std::string message) {
  complaints.push_back({where, std::move(message)});
  if (complaints.size() < kMostComplaints) return;
  std::vector<Diagnostic> all = sorted_complaints();
  all.push_back({where, fmt::format("too many errors: these are the first {}", kMostComplaints)});
  throw InputError(std::move(all));
}

std::vector<Diagnostic> FileReading::sorted_complaints() const {
  std::vector<Diagnostic> sorted = complaints;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Diagnostic& a, const Diagnostic& b) { return in_order(a.where, b.where); });
  return sorted;
}

void FileReading::throw_if_any() const {
  if (!complaints.empty()) throw InputError(sorted_complaints());
}

bool FileReading::defines(std::string_view kind, const std::string& name) const {
  const auto own = own_names.find(kind);
  return own != own_names.end() && own->second.contains(name);
}

std::string FileReading::name_in_model(std::string_view kind, const std::string& name) const {
  if (defines(kind, name)) return prefix + name;
  return includer != nullptr ? includer->name_in_model(kind, name) : name;
}

std::string FileReading::name_in_file(std::string_view kind, const std::string& name) const {
  if (name.starts_with(prefix) && defines(kind, name.substr(prefix.size()))) return name.substr(prefix.size());
  return includer != nullptr ? includer->name_in_file(kind, name) : name;
}

toml::table parse_toml(std::string_view text, const std::string& file) {
  NestingCheck(text, file).run();
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    const auto begin = error.source().begin;
    throw InputError(SourceLocation{file, static_cast<int>(begin.line), static_cast<int>(begin.column)},
                     fmt::format("not TOML: {}", error.description()));
  }
}

void check_format(const TableReader& document, int known) {
  if (!document.require({"format"})) return;
  const auto format = document.number("format");
  if (!format || *format == known) return;
  document.complain("format", fmt::format("'format' must be {}, found {}", known, *format));
}

std::string read_text_file(const std::filesystem::path& file) {
  const auto refuse = [&](const std::string& reason) {
    throw InputError(SourceLocation{.file = file.generic_string()}, reason);
  };
  OpenFile open_file(file);
  const bool holds_nul = file.native().find('\0') != std::string::npos;
  if (!open_file.is_open() || holds_nul) refuse("cannot read the file: is the path right?");
  if (!S_ISREG(open_file.mode())) {
    refuse(fmt::format("cannot read the file: it is {}, expected a regular file", kind_of(open_file.mode())));
  }
  std::string text;
  ssize_t count = 0;
  while ((count = open_file.read_more(text)) > 0) {
    if (text.size() > kMostBytes) refuse(fmt::format("the file is longer than {} MiB", kMostBytes >> 20U));
  }
  if (count < 0) refuse(fmt::format("cannot read the file: {}", std::strerror(errno)));
  return text;
}

std::string title_with_name(const toml::table& table, std::string_view kind) {
  const toml::node* name = table.get("name");
  return name != nullptr && name->is_string() ? fmt::format("{} '{}'", kind, **name->as_string()) : std::string(kind);
}

double number_in(const toml::node& node) {
  if (const auto* whole = node.as_integer()) return static_cast<double>(**whole);
  return **node.as_floating_point();
}

std::string_view type_name(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return node.is_array_of_tables() ? "a list of tables" : "a list";
    case toml::node_type::string:
      return "a string";
    case toml::node_type::integer:
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

TableReader::TableReader(const toml::table& table, std::string title, const KnownKeys& known, FileReading& reading)
    : table_(&table), title_(std::move(title)), reading_(&reading) {
  const std::vector<std::string> names(known.begin(), known.end());
  for (const auto& [key, value] : table) {
    if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
    complain_at(reading_->at(key.source()),
                fmt::format("unknown key '{}': {}", key.str(), suggestion(key.str(), names, "keys")));
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
  if (const auto value = node(key)->value_exact<std::string>()) return value;
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
  complain(key, fmt::format("'{}' has {} characters, at most {} are allowed: result files are named by it", key,
                            value.size(), kLongest));
}

std::string TableReader::name() const {
  if (!require({"name"})) return "";
  const auto value = text("name");
  if (value && value->empty()) complain("name", "'name' must not be empty");
  if (value) require_fit_for_files("name", *value);
  if (!value || value->empty()) return "";
  if (!reading_->prefix.empty()) require_short("name", reading_->prefix + *value);
  return reading_->prefix + *value;
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

void TableReader::complain(std::string_view key, std::string_view message) const { complain_at(where(key), message); }

void TableReader::complain(std::string_view message) const { complain_at(where(), message); }

void TableReader::complain_at(const SourceLocation& where, std::string_view message) const {
  reading_->complain(where, title_.empty() ? std::string(message) : fmt::format("{}: {}", title_, message));
}

}  // namespace concord
