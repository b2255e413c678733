#include "common/reading/toml_document.h"

#include <fmt/format.h>

#include <vector>

#include "common/error.h"

namespace concord {

namespace {

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

}  // namespace

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

}  // namespace concord
