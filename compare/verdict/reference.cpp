#include "compare/verdict/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "common/error.h"
#include "compare/verdict/columns.h"

namespace concord::compare {

namespace {

/// A time stands on the output grid if it is nearer to it than this part of an interval.
constexpr double kOnGrid = 1e-6;

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
