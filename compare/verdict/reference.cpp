#include "compare/verdict/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>

#include "common/error.h"
#include "common/reading/magnitude.h"
#include "common/reading/text_file.h"

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
    for (std::size_t k = 1; k < names.size(); ++k) reference_.columns.push_back(column_named(names[k]));
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
      refuse(fmt::format("column '{}': the unit must be said, {}", header, unit));
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
    for (const QuantityRow& row : *rows) {
      if (row.quantity == quantity) return row.scale;
      const bool same_side = row.quantity.kind == quantity.kind && row.quantity.owner == quantity.owner &&
                             row.quantity.side == quantity.side;
      if (same_side && row.quantity.component / 3 == quantity.component / 3) scale = std::max(scale, row.scale);
    }
  }
  return scale;
}

/// Largest length of the vector that the column is a component of, over the run; of a number alone its largest size.
double peak_of(const Column& column, const Trajectory& run) {
  const bool is_vector = column.field == Field::position || column.field == Field::velocity ||
                         column.field == Field::angular_velocity || column.field == Field::euler_parameter;
  double peak = 0.0;
  for (const Sample& sample : run.samples) {
    double square = 0.0;
    Column part = column;
    const int count = column.field == Field::euler_parameter ? 4 : 3;
    for (part.component = 0; is_vector && part.component < count; ++part.component) {
      square += std::pow(value_of(part, sample), 2);
    }
    peak = std::max(peak, is_vector ? std::sqrt(square) : std::abs(value_of(column, sample)));
  }
  return peak;
}

bool is_unique(const Verdict& verdict, const Quantity& quantity) {
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      if (row.quantity == quantity) return row.unique;
    }
  }
  return true;  // a component that the joint cannot carry: zero, and unique
}

/// Whether a column's number follows from the machine alone. One in axes that have no row mixes the components of the
/// row's axes: all of them must be unique.
bool is_judged(const Verdict& verdict, const Column& column) {
  auto quantity = quantity_of(column);
  if (!quantity) return true;
  if (column.field != Field::total_global && column.field != Field::element_global)
    return is_unique(verdict, *quantity);
  const int first = column.component / 3 * 3;
  bool all = true;
  for (quantity->component = first; quantity->component < first + 3; ++quantity->component) {
    all = all && is_unique(verdict, *quantity);
  }
  return all;
}

/// A column without a sign of its own: one of the Euler parameters of a body or of a ball.
bool has_free_sign(const Column& column) {
  return column.field == Field::euler_parameter || (column.field == Field::joint_coordinate && column.unit == "1");
}

double difference_of(const Column& column, const Sample& sample, double said) {
  const double value = value_of(column, sample);
  const double difference = std::abs(value - said);
  return has_free_sign(column) ? std::min(difference, std::abs(value + said)) : difference;
}

/// Both solvers' runs at the times of a reference.
struct RunsAtTimes {
  const Verdict& verdict;
  std::vector<std::size_t> samples;

  [[nodiscard]] const Sample& sample(std::size_t who, std::size_t k) const {
    return verdict.trajectories[who]->samples.at(samples[k]);
  }
};

/// Whether the numbers of a reference fit another column, or its opposite, within the allowed error at every time.
bool fits(const RunsAtTimes& runs, const std::vector<double>& values, const Column& other, double sign,
          double allowed) {
  for (std::size_t who = 0; who < 2; ++who) {
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (!(std::abs(value_of(other, runs.sample(who, k)) - sign * values[k]) <= allowed)) return false;
    }
  }
  return true;
}

/// Whether two columns are of one owner and one unit.
bool is_kin(const Column& one, const Column& other) {
  const auto is_of_body = [](const Column& column) { return column.field <= Field::modal_acceleration; };
  const auto is_of_element = [](const Column& column) { return column.field >= Field::element; };
  return one.owner == other.owner && one.unit == other.unit && is_of_body(one) == is_of_body(other) &&
         is_of_element(one) == is_of_element(other) &&
         (one.field == Field::coupling) == (other.field == Field::coupling);
}

/// What else of the same owner the numbers of a column that misses would fit: on the other side, in other axes, of the
/// other sign. Empty if nothing, or if they are all about zero and would fit much.
std::string hint(const Model& model, const RunsAtTimes& runs, const ReferenceColumn& column, double allowed) {
  const double peak = std::abs(*std::max_element(column.values.begin(), column.values.end(),
                                                 [](double a, double b) { return std::abs(a) < std::abs(b); }));
  if (peak <= 10.0 * allowed) return "";
  if (fits(runs, column.values, column.column, -1.0, allowed)) return "; it has the other sign";
  for (const double sign : {1.0, -1.0}) {
    for (const auto& columns :
         {reaction_columns(model), element_columns(model), motion_columns(model), further_columns(model)}) {
      for (const Column& other : columns) {
        if (!is_kin(other, column.column) || !fits(runs, column.values, other, sign, allowed)) continue;
        return fmt::format("; it agrees with {}{}: on another side, in other axes, or of the other sign?",
                           sign < 0.0 ? "-" : "", other.name);
      }
    }
  }
  return "";
}

void add_finding(const Model& model, const RunsAtTimes& runs, const ReferenceColumn& column, const ReferenceRow& row,
                 Verdict& verdict) {
  verdict.findings.push_back(
      {fmt::format("{}, {}, against the reference: off by {:.3g} (cartesian) and {:.3g} (relative) {} at t = {:.4g} s, "
                   "stated error {:.3g}",
                   row.of, row.component, row.differences[0], row.differences[1], row.unit, row.t, row.allowed),
       fmt::format("reference: {}{}", verdict.reference_file, hint(model, runs, column, row.allowed))});
}

}  // namespace

Reference read_reference(const std::filesystem::path& file, const Model& model) {
  return ReferenceReader(file, model).read();
}

void check_times(const Reference& reference, const RunOptions& run) {
  samples_at(reference, run.until, static_cast<std::size_t>(run.samples));
}

namespace {

/// Solvers and audit agree, and the reference does not: what all three are told is wrong, or the reference.
void blame_statement(Verdict& verdict) {
  const auto row = std::find_if(verdict.references.begin(), verdict.references.end(),
                                [](const ReferenceRow& one) { return one.is_judged && !one.agrees; });
  const std::string where = row->of.substr(0, row->of.find(" on "));
  verdict.attribution =
      Attribution{2, Term::statement, where,
                  "both agree with each other and with the audit; look into the model file, how it is read, and the "
                  "reference"};
  verdict.notes.push_back("to blame: " + describe(*verdict.attribution));
}

}  // namespace

void judge_reference(const Model& model, const Reference& reference, Verdict& verdict) {
  verdict.reference_file = std::filesystem::path(reference.file).filename().string();
  if (!verdict.trajectories[0] || !verdict.trajectories[1]) return;  // a failure already
  const Trajectory& run = *verdict.trajectories[0];
  const RunsAtTimes runs{verdict, samples_at(reference, run.samples.back().state.t, run.samples.size() - 1)};
  for (const ReferenceColumn& column : reference.columns) {
    ReferenceRow& row = verdict.references.emplace_back();
    row.of = describe_owner(model, column.column);
    row.component = describe_component(column.column);
    row.unit = column.column.unit;
    row.is_judged = is_judged(verdict, column.column);
    const auto quantity = quantity_of(column.column);
    const double scale = quantity ? scale_of(verdict, *quantity) : peak_of(column.column, run);
    row.allowed = column.is_relative ? column.error * scale : column.error;
    double worst = -1.0;
    for (std::size_t k = 0; k < column.values.size(); ++k) {
      for (std::size_t who = 0; who < 2; ++who) {
        const double difference = difference_of(column.column, runs.sample(who, k), column.values[k]);
        row.differences[who] = std::max(row.differences[who], difference);
        if (difference <= worst) continue;
        worst = difference;
        row.t = reference.times[k];
      }
      row.peak = std::max(row.peak, std::abs(column.values[k]));
    }
    row.agrees = worst <= row.allowed;
    if (row.is_judged && !row.agrees) add_finding(model, runs, column, row, verdict);
  }
  const bool any_off = std::any_of(verdict.references.begin(), verdict.references.end(),
                                   [](const ReferenceRow& row) { return row.is_judged && !row.agrees; });
  if (!any_off || verdict.outcome != Outcome::agree) return;
  verdict.outcome = Outcome::differ;
  blame_statement(verdict);
}

}  // namespace concord::compare
