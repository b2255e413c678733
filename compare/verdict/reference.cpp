#include "compare/verdict/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/error.h"
#include "compare/audit/places.h"
#include "compare/verdict/columns.h"

namespace concord::compare {

namespace {

/// A time stands on the output grid if it is nearer to it than this part of an interval, or than half of the last digit
/// that it is written with.
constexpr double kOnGrid = 1e-6;
constexpr double kOnGridAsWritten = 0.05;

/// Output times of a run, by their number, that are the reference's times.
std::vector<std::size_t> samples_at(const Reference& reference, double until, std::size_t count) {
  const auto intervals = static_cast<double>(count);
  std::vector<std::size_t> samples;
  for (std::size_t k = 0; k < reference.times.size(); ++k) {
    const double place = reference.times[k] / until * intervals;
    const double nearest = std::round(place);
    const double as_written = 1.01 * reference.time_roundings[k] / until * intervals;
    const double allowed = std::clamp(as_written, kOnGrid, kOnGridAsWritten);
    if (nearest < 0.0 || nearest > intervals || !(std::abs(place - nearest) <= allowed)) {
      throw InputError(
          {reference.file, reference.lines[k], 1},
          fmt::format("reference: t = {:.9g} s is no output time of the run, {:g} s in {} intervals (the nearest is "
                      "{:.9g} s): choose --until and --samples so that it is; reactions are not interpolated",
                      reference.times[k], until, count, std::clamp(nearest, 0.0, intervals) * until / intervals));
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

/// A column without a sign of its own: one of the Euler parameters of a body or of a ball.
bool has_free_sign(const Column& column) {
  return column.field == Field::euler_parameter || (column.field == Field::joint_coordinate && column.unit == "1");
}

/// Both solvers' runs at the times of a reference.
struct RunsAtTimes {
  const Verdict& verdict;
  std::vector<std::size_t> samples;

  [[nodiscard]] const Sample& sample(std::size_t who, std::size_t k) const {
    return verdict.trajectories[who]->samples.at(samples[k]);
  }
};

/// Rotation of the side of a joint in a sample, from its frame to global axes.
Mat3 orientation_of(const Model& model, const Column& column, const Sample& sample) {
  const Attachment& attachment = model.joints[static_cast<std::size_t>(column.owner)].on(column.side);
  return place(attachment, sample.state.bodies[static_cast<std::size_t>(attachment.body)]).A_joint;
}

/// Whether a column's number follows from the machine alone. One in global axes does where components of the joint's
/// frame that are not unique have no part along that axis.
bool is_judged(const Model& model, const RunsAtTimes& runs, const Column& column) {
  const auto quantity = quantity_of(column);
  if (!quantity) return true;
  if (column.field != Field::reaction_global && column.field != Field::total_global) {
    return is_unique(runs.verdict, *quantity);
  }
  constexpr double kNoPart = 1e-12;
  const bool is_total = column.field == Field::total_global;
  const int first = column.component / 3 * 3;
  std::array<bool, 3> is_open{};
  for (int c = 0; c < 3; ++c) {
    const Quantity own{is_total ? Kind::total : Kind::reaction, column.owner, column.side, first + c};
    is_open[static_cast<std::size_t>(c)] = !is_unique(runs.verdict, own);
  }
  if (is_open == std::array<bool, 3>{}) return true;
  for (std::size_t k = 0; k < runs.samples.size(); ++k) {
    const Mat3 A = orientation_of(model, column, runs.sample(0, k));
    for (int c = 0; c < 3; ++c) {
      if (is_open[static_cast<std::size_t>(c)] && std::abs(A(column.component - first, c)) > kNoPart) return false;
    }
  }
  return true;
}

/// The sign by which Euler parameters of a reference are those of a solver in sample k: one for all that it gives of an
/// orientation, so that an inverse rotation is none. 1 for all other columns.
double sign_of(const RunsAtTimes& runs, std::size_t who, std::size_t k, const Reference& reference,
               const Column& column) {
  if (!has_free_sign(column)) return 1.0;
  double product = 0.0;
  for (const ReferenceColumn& other : reference.columns) {
    const bool is_of_it =
        has_free_sign(other.column) && other.column.field == column.field && other.column.owner == column.owner;
    if (is_of_it) product += value_of(other.column, runs.sample(who, k)) * other.values[k];
  }
  return product < 0.0 ? -1.0 : 1.0;
}

/// Whether the Euler parameters of a body are, within the allowed error, those of the inverse rotation.
bool is_inverse(const RunsAtTimes& runs, const Reference& reference, const Column& column, double allowed) {
  if (column.field != Field::euler_parameter) return false;
  for (std::size_t k = 0; k < runs.samples.size(); ++k) {
    std::array<double, 2> off{};  // with either sign
    for (const ReferenceColumn& other : reference.columns) {
      if (other.column.field != column.field || other.column.owner != column.owner) continue;
      const double inverse = (other.column.component == 0 ? 1.0 : -1.0) * value_of(other.column, runs.sample(0, k));
      off[0] = std::max(off[0], std::abs(inverse - other.values[k]));
      off[1] = std::max(off[1], std::abs(inverse + other.values[k]));
    }
    if (!(std::min(off[0], off[1]) <= allowed)) return false;
  }
  return true;
}

/// What both runs leave open of a column: round-off of the machine's largest number of that unit, or what the solvers
/// differ by, as far as that is next to nothing beside it. A part of a number that is zero is no error to hold them to.
double left_open(const RunsAtTimes& runs, const Column& column, double largest) {
  constexpr double kRoundOff = 1e-14;
  constexpr double kNextToNothing = 1e-9;
  double difference = 0.0;
  for (std::size_t k = 0; k < runs.samples.size(); ++k) {
    const double one = value_of(column, runs.sample(0, k));
    const double other = value_of(column, runs.sample(1, k));
    difference = std::max(difference, std::abs(one - (has_free_sign(column) && one * other < 0.0 ? -other : other)));
  }
  return std::max(kRoundOff * largest, std::min(difference, kNextToNothing * largest));
}

/// The largest numbers of a run by their unit, forces and torques, and what moves and what turns, by the machine's
/// length for each other; of a machine that stands still its length in the time of the run.
std::map<std::string, double> largest_numbers(const Model& model, const Trajectory& run) {
  const double length = model.length_scale();
  const double until = run.samples.back().state.t;
  std::map<std::string, double> largest{{"1", 1.0}, {"m", length}, {"rad", 1.0}, {"m/s", length / until}};
  for (const auto& columns : {reaction_columns(model), element_columns(model), motion_columns(model)}) {
    for (const Column& column : columns) {
      double& size = largest[column.unit];
      for (const Sample& sample : run.samples) size = std::max(size, std::abs(value_of(column, sample)));
    }
  }
  const std::array<std::array<const char*, 2>, 3> pairs{{{"m/s", "rad/s"}, {"m/s2", "rad/s2"}, {"N m", "N"}}};
  for (const auto& [along, about] : pairs) {
    double& one = largest[along];
    double& other = largest[about];
    one = std::max(one, length * other);
    other = std::max(other, one / length);
  }
  return largest;
}

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

/// "; it is 1000 times as large: in other units?" if the numbers of a reference are a multiple of the column's, else
/// empty.
std::string hint_at_factor(const RunsAtTimes& runs, const ReferenceColumn& column, double allowed) {
  double product = 0.0;
  double square = 0.0;
  for (std::size_t k = 0; k < column.values.size(); ++k) {
    const double value = value_of(column.column, runs.sample(0, k));
    product += value * column.values[k];
    square += value * value;
  }
  const double factor = product / square;
  if (!std::isfinite(factor) || factor == 0.0) return "";
  double difference = 0.0;
  for (std::size_t k = 0; k < column.values.size(); ++k) {
    difference = std::max(difference, std::abs(factor * value_of(column.column, runs.sample(0, k)) - column.values[k]));
  }
  if (!(difference <= allowed * std::abs(factor))) return "";  // the error, too, is in those units
  return fmt::format("; it is {:.6g} times as large{}", factor,
                     std::abs(std::log10(std::abs(factor))) > 1.0 ? ": in other units?" : "");
}

/// What else of the same owner the numbers of a column that misses would fit: on the other side, in other axes, of the
/// other sign. Empty if nothing, or if they are all about zero and would fit much.
std::string hint(const Model& model, const RunsAtTimes& runs, const Reference& reference, const ReferenceColumn& column,
                 double allowed) {
  const double peak = std::abs(*std::max_element(column.values.begin(), column.values.end(),
                                                 [](double a, double b) { return std::abs(a) < std::abs(b); }));
  std::string factor = column.values.size() > 2 ? hint_at_factor(runs, column, allowed) : "";
  if (peak <= 10.0 * allowed) return factor;
  if (is_inverse(runs, reference, column.column, allowed)) return "; it is the inverse rotation";
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
  return factor;
}

void add_finding(const ReferenceRow& row, const std::string& hint, Verdict& verdict) {
  verdict.findings.push_back(
      {fmt::format("{}, {}, against the reference: off by {:.3g} (cartesian) and {:.3g} (relative){} at t = {:.4g} s, "
                   "stated error {:.3g}",
                   row.of, row.component, row.differences[0], row.differences[1], row.unit == "1" ? "" : " " + row.unit,
                   row.t, row.allowed),
       fmt::format("reference: {}{}", verdict.reference_file, hint)});
}

/// Fills in how far both solvers are off, where, and whether that is allowed.
void measure_row(const RunsAtTimes& runs, const Reference& reference, const ReferenceColumn& column,
                 ReferenceRow& row) {
  double worst = -1.0;
  for (std::size_t k = 0; k < column.values.size(); ++k) {
    for (std::size_t who = 0; who < 2; ++who) {
      const double said = sign_of(runs, who, k, reference, column.column) * column.values[k];
      const double difference = std::abs(value_of(column.column, runs.sample(who, k)) - said);
      row.differences[who] = std::max(row.differences[who], difference);
      if (difference <= worst) continue;
      worst = difference;
      row.t = reference.times[k];
    }
    row.peak = std::max(row.peak, std::abs(column.values[k]));
  }
  row.agrees = worst <= row.allowed;
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
  std::map<std::string, double> largest = largest_numbers(model, run);
  for (const ReferenceColumn& column : reference.columns) {
    ReferenceRow& row = verdict.references.emplace_back();
    row.of = describe_owner(model, column.column);
    row.component = describe_component(column.column);
    row.unit = column.column.unit;
    row.is_judged = is_judged(model, runs, column.column);
    const auto quantity = quantity_of(column.column);
    const double scale = quantity ? scale_of(verdict, *quantity) : peak_of(column.column, run);
    row.allowed = std::max(column.is_relative ? column.error * scale : column.error,
                           left_open(runs, column.column, largest[row.unit]));
    measure_row(runs, reference, column, row);
    if (row.is_judged && !row.agrees) add_finding(row, hint(model, runs, reference, column, row.allowed), verdict);
  }
  const bool any_off = std::any_of(verdict.references.begin(), verdict.references.end(),
                                   [](const ReferenceRow& row) { return row.is_judged && !row.agrees; });
  if (!any_off || verdict.outcome != Outcome::agree) return;
  verdict.outcome = Outcome::differ;
  blame_statement(verdict);
}

}  // namespace concord::compare
