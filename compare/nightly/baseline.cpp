#include "compare/nightly/baseline.h"

#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "common/error.h"
#include "common/reading/text_file.h"
#include "compare/nightly/night.h"
#include "compare/report/files.h"
#include "compare/report/whole_number.h"

namespace concord::compare::nightly {

namespace {

constexpr int kBaselineFormat = 1;
constexpr std::string_view kBaselineTitle = "concord baseline";
constexpr std::size_t kCaseFields = 10;  // and one more: what the case was asked, where that was written down
constexpr std::size_t kComponentFields = 8;

/// A solver's NaN is no number that a later night could be compared with.
bool is_number(const std::optional<double>& value) { return value && std::isfinite(*value); }

std::string rounded_digits(const std::optional<double>& value) {
  return is_number(value) ? fmt::format("{:.2f}", *value) : "-";
}
std::string rounded_value(const std::optional<double>& value) {
  return is_number(value) ? fmt::format("{:.7g}", *value) : "-";
}

std::string case_line(const Result& one) {
  std::vector<std::string> fields{"case",
                                  one.id,
                                  to_string(one.ending),
                                  fmt::format("{} of {}", one.judged, one.total),
                                  one.cost[0].integrator,
                                  fmt::format("{}", one.cost[0].steps),
                                  fmt::format("{}", one.cost[0].evaluations),
                                  one.cost[1].integrator,
                                  fmt::format("{}", one.cost[1].steps),
                                  fmt::format("{}", one.cost[1].evaluations)};
  if (!one.definition.empty()) fields.push_back(one.definition);
  return format_fields(fields);
}

std::string component_line(const Component& one) {
  return format_fields({"", one.name, rounded_digits(one.same_state), rounded_digits(one.resolvable),
                        rounded_digits(one.same_run), rounded_digits(one.refined), rounded_value(one.peak),
                        rounded_value(one.scale)});
}

std::string user_words() {
  const passwd* user = getpwuid(geteuid());
  return user != nullptr ? user->pw_name : fmt::format("user {}", geteuid());
}

/// Reads line by line and knows where it is.
class BaselineParser {
 public:
  BaselineParser(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  Baselines parse() {
    read_title();
    while (next_line()) {
      if (line_.empty() || line_.front() == '#') continue;
      const auto fields = split_fields(line_);
      if (!fields) refuse("a quotation mark is not closed");
      if (fields->front() == "case") {
        add_case(*fields);
      } else if (fields->front().empty()) {
        add_component(*fields);
      } else {
        refuse(fmt::format("a line begins with 'case' or with a comma, found '{}'", fields->front()));
      }
    }
    return std::move(baselines_);
  }

 private:
  bool next_line() {
    if (at_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    line_ = text_.substr(at_, end - at_);
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    at_ = end + 1;
    ++number_;
    return true;
  }

  void read_title() {
    const bool has_line = next_line();
    const auto fields = has_line ? split_fields(line_) : std::nullopt;
    if (!fields || fields->size() != 2 || fields->front() != kBaselineTitle) {
      refuse(fmt::format("this is no baseline: the first line must be '{},{}'", kBaselineTitle, kBaselineFormat));
    }
    if (fields->back() == fmt::format("{}", kBaselineFormat)) return;
    refuse(fmt::format("version {} of the baselines is not known: this program reads version {}", fields->back(),
                       kBaselineFormat));
  }

  void add_case(const std::vector<std::string>& fields) {
    const bool tells_definition = fields.size() == kCaseFields + 1;
    if (!tells_definition) require_count(fields, kCaseFields);
    Result one;
    if (tells_definition) one.definition = fields.back();
    one.id = fields[1];
    try {
      one.ending = ending_of(fields[2]);
    } catch (const std::runtime_error& error) {
      refuse(error.what());
    }
    const std::size_t of = fields[3].find(" of ");
    if (of == std::string::npos) refuse(fmt::format("expected 'N of M', found '{}'", fields[3]));
    one.judged = static_cast<int>(count(fields[3].substr(0, of)));
    one.total = static_cast<int>(count(fields[3].substr(of + 4)));
    one.cost = {Cost{fields[4], count(fields[5]), count(fields[6])},
                Cost{fields[7], count(fields[8]), count(fields[9])}};
    const auto [entry, is_new] = baselines_.emplace(one.id, one);
    if (!is_new) refuse(fmt::format("case '{}' stands there twice", one.id));
    current_ = &entry->second;
    names_.clear();
  }

  void add_component(const std::vector<std::string>& fields) {
    require_count(fields, kComponentFields);
    if (current_ == nullptr) refuse("a component stands before the first case");
    Component one;
    one.name = fields[1];
    if (!names_.insert(one.name).second) {
      refuse(fmt::format("'{}' of case '{}' stands there twice", one.name, current_->id));
    }
    one.same_state = value(fields[2]);
    one.resolvable = value(fields[3]);
    one.same_run = value(fields[4]);
    one.refined = value(fields[5]);
    one.peak = value(fields[6]);
    one.scale = value(fields[7]).value_or(0.0);
    current_->components.push_back(std::move(one));
  }

  void require_count(const std::vector<std::string>& fields, std::size_t count) const {
    if (fields.size() != count) refuse(fmt::format("expected {} fields, found {}", count, fields.size()));
  }

  template <class Number>
  Number number(const std::string& field) const {
    const auto found = whole_text_as<Number>(field);
    if (!found) refuse(fmt::format("expected a number, found '{}'", field));
    return *found;
  }
  [[nodiscard]] long count(const std::string& field) const {
    const auto found = number<long>(field);
    if (found < 0) refuse(fmt::format("expected a count, found '{}'", field));
    return found;
  }
  [[nodiscard]] std::optional<double> value(const std::string& field) const {
    if (field == "-") return std::nullopt;
    const auto found = number<double>(field);
    if (!std::isfinite(found)) refuse(fmt::format("expected a finite number, found '{}'", field));
    return found;
  }

  [[noreturn]] void refuse(const std::string& reason) const { throw InputError({file_, number_, 1}, reason); }

  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
  std::string_view line_;
  int number_ = 0;
  Baselines baselines_;
  Result* current_ = nullptr;
  std::set<std::string> names_;  // of its components
};

}  // namespace

std::string format_fields(const std::vector<std::string>& fields) {
  std::string line;
  for (std::size_t k = 0; k < fields.size(); ++k) {
    if (k > 0) line += ',';
    if (fields[k].find_first_of(",\"\n\r#") == std::string::npos) {
      line += fields[k];
      continue;
    }
    line += '"';
    for (const char c : fields[k]) line += c == '"' ? "\"\"" : c == '\n' || c == '\r' ? " " : std::string(1, c);
    line += '"';
  }
  return line;
}

std::optional<std::vector<std::string>> split_fields(std::string_view line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t k = 0; k < line.size(); ++k) {
    const char c = line[k];
    if (quoted && c == '"' && k + 1 < line.size() && line[k + 1] == '"') {
      fields.back() += line[++k];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  if (quoted) return std::nullopt;
  return fields;
}

std::string format_baselines(const Baselines& baselines) {
  std::string text = fmt::format("{},{}\n", kBaselineTitle, kBaselineFormat);
  text +=
      "# Written by `concord accept` alone.\n"
      "# case,name,ending,judged,integrator,steps,evaluations,integrator,steps,evaluations: Cartesian, relative; at "
      "the "
      "end what was asked\n"
      "# ,component,same state,resolvable,same run,refined,peak,scale: digits; peak and scale in SI units\n";
  for (const auto& [name, one] : baselines) {
    text += case_line(one) + '\n';
    for (const Component& component : one.components) text += component_line(component) + '\n';
  }
  return text;
}

Baselines parse_baselines(std::string_view text, const std::string& file) { return BaselineParser(text, file).parse(); }

Baselines read_baselines(const std::filesystem::path& file) {
  std::error_code unknown;
  if (!std::filesystem::exists(std::filesystem::symlink_status(file, unknown))) return {};
  return parse_baselines(read_text_file(file), file.generic_string());
}

std::filesystem::path log_of(const std::filesystem::path& baselines) {
  return std::filesystem::path(baselines).replace_extension(".log");
}

void write_down(const std::filesystem::path& baselines, const Origin& origin, const std::string& reason,
                const std::string& changes) {
  const std::filesystem::path log = log_of(baselines);
  std::error_code unknown;
  const std::string earlier = std::filesystem::exists(log, unknown) ? read_text_file(log) : "";
  std::string in_one_line = reason;
  std::replace(in_one_line.begin(), in_one_line.end(), '\n', ' ');
  write_file(log, earlier + fmt::format("{} UTC, {}, {} ({}, {}): {}\n{}", utc_now(), user_words(), origin.version,
                                        origin.commit, origin.compiler, in_one_line, changes));
}

Result as_baseline(const Result& result) {
  const Baselines kept = parse_baselines(format_baselines({{result.id, result}}), result.id);
  return kept.begin()->second;
}

}  // namespace concord::compare::nightly
