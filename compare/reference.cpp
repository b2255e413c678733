#include "compare/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>

#include "common/error.h"

namespace concord::compare {

namespace {

/// A time stands on the output grid if it is nearer to it than this part of an interval.
constexpr double kOnGrid = 1e-6;

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
  if (trouble != std::errc() || read != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Every column that a reference may have, by its name: "D.child.T_z".
std::map<std::string, Quantity> known_columns(const Model& model) {
  std::map<std::string, Quantity> known;
  const auto add = [&](const std::string& owner, Kind kind, int place, Side side) {
    for (int c = 0; c < 6; ++c) {
      const char* on = side == Side::child ? "child" : "parent";
      known.try_emplace(fmt::format("{}.{}.{}", owner, on, component_names()[c]), Quantity{kind, place, side, c});
    }
  };
  for (const Side side : {Side::parent, Side::child}) {
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      add(model.joints[k].name, Kind::reaction, static_cast<int>(k), side);
    }
    for (std::size_t k = 0; k < model.elements.size(); ++k) {
      if (end_of(model.elements[k], side) == nullptr) continue;
      add(model.elements[k].name, Kind::element, static_cast<int>(k), side);
    }
  }
  return known;
}

struct StatedError {
  double size = 0.0;
  bool is_relative = true;
  std::string unit;
};

class ReferenceReader {
 public:
  ReferenceReader(const std::filesystem::path& file, const Model& model)
      : file_(file), model_(model), known_(known_columns(model)) {
    reference_.file = file.string();
  }

  Reference read() {
    std::ifstream stream(file_);
    if (!stream) refuse("cannot be read");
    std::string text;
    while (std::getline(stream, text)) {
      ++line_;
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
    const bool is_known_unit = unit == "%" || unit == "N" || unit == "N m";
    if (!size || !(*size >= 0.0) || !is_known_unit) {
      refuse(
          fmt::format("'{}': expected a stated error such as `error = 0.5 %` or `error D.child.T_z = 0.02 N m`", text));
    }
    if (column.empty() && unit != "%") refuse("an error of all columns must be in %, because their units differ");
    errors_[column] = {unit == "%" ? *size / 100.0 : *size, unit == "%", unit};
  }

  void read_header(const std::vector<std::string>& names) {
    has_header_ = true;
    if (names.front() != "t [s]") refuse(fmt::format("the first column is '{}', expected 't [s]'", names.front()));
    for (std::size_t k = 1; k < names.size(); ++k) reference_.columns.push_back(column_named(names[k]));
    if (reference_.columns.empty()) refuse("the header names no component beside the time");
  }

  [[nodiscard]] ReferenceColumn column_named(const std::string& header) const {
    const std::size_t bracket = header.rfind('[');
    const std::string name = trimmed(header.substr(0, bracket));
    const auto found = known_.find(name);
    if (found == known_.end()) {
      refuse(fmt::format("the model has no '{}'; columns are called JOINT.child.F_x [N] ... JOINT.parent.T_z [N m]",
                         name));
    }
    const std::string unit = fmt::format("[{}]", unit_of(model_, found->second));
    if (bracket == std::string::npos || header.substr(bracket) != unit) {
      refuse(fmt::format("column '{}': the unit must be said, {}", header, unit));
    }
    ReferenceColumn column;
    column.name = name;
    column.quantity = found->second;
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
      const auto is_it = [&, &wanted = name](const ReferenceColumn& column) { return column.name == wanted; };
      if (name.empty() || std::any_of(reference_.columns.begin(), reference_.columns.end(), is_it)) continue;
      refuse(fmt::format("an error is stated for '{}', which is no column", name));
    }
    for (ReferenceColumn& column : reference_.columns) {
      auto found = errors_.find(column.name);
      if (found == errors_.end()) found = errors_.find("");
      if (found == errors_.end()) {
        refuse(fmt::format("'{}' has no stated error: say how far the source may be off, such as `# error = 1 %`",
                           column.name));
      }
      const StatedError& stated = found->second;
      if (!stated.is_relative && stated.unit != unit_of(model_, column.quantity)) {
        refuse(fmt::format("the error of '{}' is in {}, the column in {}", column.name, stated.unit,
                           unit_of(model_, column.quantity)));
      }
      column.error = stated.size;
      column.is_relative = stated.is_relative;
    }
  }

  std::filesystem::path file_;
  const Model& model_;
  std::map<std::string, Quantity> known_;
  std::map<std::string, StatedError> errors_;
  Reference reference_;
  bool has_header_ = false;
  int line_ = 0;
};

double value_of(const Quantity& quantity, const Evaluation& evaluation) {
  const Wrench& wrench = quantity.kind == Kind::element
                             ? evaluation.elements.at(quantity.owner).on_side(quantity.side).in_C
                             : evaluation.joints.at(quantity.owner).reaction_on(quantity.side).in_C;
  return wrench.vector()(quantity.component);
}

/// Output times of a run, by their number, that are the reference's times.
std::vector<std::size_t> samples_at(const Reference& reference, double until, std::size_t count) {
  const auto intervals = static_cast<double>(count);
  std::vector<std::size_t> samples;
  for (std::size_t k = 0; k < reference.times.size(); ++k) {
    const double place = reference.times[k] / until * intervals;
    const double nearest = std::round(place);
    if (nearest < 0.0 || nearest > intervals || std::abs(place - nearest) > kOnGrid) {
      throw InputError(
          {reference.file, reference.lines[k], 1},
          fmt::format("reference: t = {:.9g} s is no output time of the run, {:g} s in {} intervals: choose "
                      "--until and --samples so that it is; reactions are not interpolated",
                      reference.times[k], until, count));
    }
    samples.push_back(static_cast<std::size_t>(nearest));
  }
  return samples;
}

/// Scale of a component: its own row's, or, where the joint cannot carry it, the largest of its kind on that joint.
double scale_of(const Verdict& verdict, const Quantity& quantity) {
  double scale = 0.0;
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const Row& row : *rows) {
      if (row.quantity == quantity) return row.scale;
      const bool same_side = row.quantity.kind == quantity.kind && row.quantity.owner == quantity.owner &&
                             row.quantity.side == quantity.side;
      if (same_side && row.quantity.component / 3 == quantity.component / 3) scale = std::max(scale, row.scale);
    }
  }
  return scale;
}

bool is_judged(const Verdict& verdict, const Quantity& quantity) {
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const Row& row : *rows) {
      if (row.quantity == quantity) return row.unique;
    }
  }
  return true;  // a component that the joint cannot carry: zero, and unique
}

void add_finding(const Model& model, const ReferenceColumn& column, const ReferenceRow& row, Verdict& verdict) {
  verdict.findings.push_back(
      {fmt::format("{}, {}, against the reference: off by {:.3g} (cartesian) and {:.3g} (relative) {} at t = {:.4g} s, "
                   "stated error {:.3g}",
                   describe_owner(model, column.quantity), describe_component(column.quantity), row.differences[0],
                   row.differences[1], unit_of(model, column.quantity), row.t, row.allowed),
       fmt::format("reference: {}", verdict.reference_file)});
}

}  // namespace

Reference read_reference(const std::filesystem::path& file, const Model& model) {
  return ReferenceReader(file, model).read();
}

void check_times(const Reference& reference, const RunOptions& run) {
  samples_at(reference, run.until, static_cast<std::size_t>(run.samples));
}

void judge_reference(const Model& model, const Reference& reference, Verdict& verdict) {
  verdict.reference_file = std::filesystem::path(reference.file).filename().string();
  if (!verdict.trajectories[0] || !verdict.trajectories[1]) return;  // a failure already
  const Trajectory& run = *verdict.trajectories[0];
  const std::vector<std::size_t> samples = samples_at(reference, run.samples.back().state.t, run.samples.size() - 1);
  for (const ReferenceColumn& column : reference.columns) {
    ReferenceRow& row = verdict.references.emplace_back();
    row.quantity = column.quantity;
    row.is_judged = is_judged(verdict, column.quantity);
    row.allowed = column.is_relative ? column.error * scale_of(verdict, column.quantity) : column.error;
    double worst = -1.0;
    for (std::size_t k = 0; k < samples.size(); ++k) {
      std::array<double, 2> differences{};
      for (std::size_t who = 0; who < 2; ++who) {
        const Sample& sample = verdict.trajectories[who]->samples.at(samples[k]);
        differences[who] = std::abs(value_of(column.quantity, sample.evaluation) - column.values[k]);
        row.differences[who] = std::max(row.differences[who], differences[who]);
      }
      row.peak = std::max(row.peak, std::abs(column.values[k]));
      if (std::max(differences[0], differences[1]) <= worst) continue;
      worst = std::max(differences[0], differences[1]);
      row.t = reference.times[k];
    }
    row.agrees = worst <= row.allowed;
    if (row.is_judged && !row.agrees) add_finding(model, column, row, verdict);
  }
  const bool any_off = std::any_of(verdict.references.begin(), verdict.references.end(),
                                   [](const ReferenceRow& row) { return row.is_judged && !row.agrees; });
  if (any_off && verdict.outcome == Outcome::agree) verdict.outcome = Outcome::differ;
}

}  // namespace concord::compare
