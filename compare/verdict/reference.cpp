#include "compare/verdict/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/error.h"
#include "compare/quantities/columns.h"
#include "compare/resolution/unique_part.h"
#include "compare/verdict/reference_convention.h"
#include "compare/verdict/reference_errors.h"
#include "compare/verdict/reference_hints.h"

namespace concord::compare {

namespace {

/// A time stands on the output grid, too, if it is nearer to it than half of the last digit that it is written with, up
/// to this part of an interval.
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

/// What a reference says of the owner of a column, and the runs, at those of its times at which the column has a number
/// that follows from the machine alone there; if there is none, at all at which it has one.
struct ChosenTimes {
  Reference reference;
  std::size_t column = 0;  // the column, among those of its owner
  RunsAtTimes runs;
  bool is_judged;
};

/// `known`: a run with NaN where a number is not unique.
ChosenTimes choose_times(const Reference& reference, const RunsAtTimes& runs, std::size_t column,
                         const Trajectory& known) {
  const ReferenceColumn& asked = reference.columns[column];
  std::vector<std::size_t> said;
  std::vector<std::size_t> judged;
  for (std::size_t k = 0; k < runs.samples.size(); ++k) {
    if (std::isnan(asked.values[k])) continue;
    said.push_back(k);
    const bool is_unique = !std::isnan(value_of(asked.column, known.samples[runs.samples[k]]));
    if (is_unique && !asked.column.is_own) judged.push_back(k);
  }
  const std::vector<std::size_t>& kept = judged.empty() ? said : judged;
  const auto of_kept = [&](const auto& numbers) {
    std::decay_t<decltype(numbers)> chosen;
    for (const std::size_t k : kept) chosen.push_back(numbers[k]);
    return chosen;
  };
  ChosenTimes chosen{{}, 0, {runs.verdict, of_kept(runs.samples)}, !judged.empty()};
  chosen.reference.times = of_kept(reference.times);
  chosen.reference.lines = of_kept(reference.lines);
  for (std::size_t k = 0; k < reference.columns.size(); ++k) {
    const ReferenceColumn& one = reference.columns[k];
    if (one.column.field != asked.column.field || one.column.owner != asked.column.owner) continue;
    if (k == column) chosen.column = chosen.reference.columns.size();
    chosen.reference.columns.push_back(one);
    chosen.reference.columns.back().values = of_kept(one.values);
  }
  return chosen;
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
    if (is_of_it && !std::isnan(other.values[k]))
      product += value_of(other.column, runs.sample(who, k)) * other.values[k];
  }
  return product < 0.0 ? -1.0 : 1.0;
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

void add_finding(const ReferenceRow& row, Verdict& verdict) {
  const std::string unit = row.unit == "1" ? "" : " " + row.unit;
  verdict.findings.push_back(
      {fmt::format("{}, {}, against the reference: off by {:.3g} (cartesian) and {:.3g} (relative){} at t = {:.4g} s, "
                   "where it says {:.6g}{} (line {}), stated error {:.3g}",
                   row.of, row.component, row.differences[0], row.differences[1], unit, row.t, row.stated, unit,
                   row.line, row.allowed),
       fmt::format("reference: {}{}{}", verdict.reference_file, row.hint.empty() ? "" : "; ", row.hint)});
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
      row.stated = said;
      row.line = reference.lines[k];
    }
    row.peak = std::max(row.peak, std::abs(column.values[k]));
  }
  row.agrees = worst <= row.allowed;
}

/// Solvers and audit agree, and the reference does not: what all three are told is wrong, or the reference.
void blame_statement(Verdict& verdict) {
  const auto excess = [](const ReferenceRow& row) {
    return is_off(row) ? std::max(row.differences[0], row.differences[1]) / row.allowed : 0.0;
  };
  const auto row =
      std::max_element(verdict.references.begin(), verdict.references.end(),
                       [&](const ReferenceRow& a, const ReferenceRow& b) { return excess(a) < excess(b); });
  const std::string where = row->of.substr(0, row->of.find(" on "));
  verdict.attribution =
      Attribution{2, Term::statement, where,
                  "both agree with each other and with the audit; look into the model file, how it is read, and the "
                  "reference"};
  verdict.notes.push_back("to blame: " + describe(*verdict.attribution));
}

/// Leaves out the times of a reference beyond what can be compared at all, and tells how many.
void cut_at_horizon(const Trajectory& run, Reference& reference, std::vector<std::size_t>& samples, Verdict& verdict) {
  const double last = last_judged(verdict);
  const auto end = std::partition_point(samples.begin(), samples.end(),
                                        [&](std::size_t sample) { return run.samples[sample].state.t <= last; });
  const auto count = static_cast<std::size_t>(end - samples.begin());
  if (count == samples.size()) return;
  verdict.notes.push_back(
      fmt::format("reference: {} of {} times lie beyond t = {:.4g} s, up to which two integrations of this motion can "
                  "agree, and are not judged",
                  samples.size() - count, samples.size(), last));
  samples.resize(count);
  reference.times.resize(count);
  for (ReferenceColumn& column : reference.columns) column.values.resize(count);
}

/// Tells of a time that is written with so few digits that another one is meant by it, perhaps.
void note_rounded_times(const Reference& reference, const Trajectory& run, const std::vector<std::size_t>& samples,
                        Verdict& verdict) {
  std::size_t rounded = 0;
  std::string first;
  const double interval = run.samples[1].state.t - run.samples[0].state.t;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double t = run.samples[samples[k]].state.t;
    if (std::abs(t - reference.times[k]) <= kOnGrid * interval || rounded++ > 0) continue;
    first = fmt::format("t = {:.9g} s (line {}) is taken for the output time {:.9g} s", reference.times[k],
                        reference.lines[k], t);
  }
  if (rounded == 0) return;
  verdict.notes.push_back(fmt::format("reference: {}, which it is to the last digit that is written{}", first,
                                      rounded > 1 ? fmt::format(", and so are {} more", rounded - 1) : ""));
}

/// What a picture shows of a column, whether it is judged or not.
void keep_for_pictures(const Reference& reference, const ReferenceColumn& column, ReferenceRow& row) {
  const auto quantity = quantity_of(column.column);
  const bool is_drawn = quantity && (quantity->kind == Kind::reaction || quantity->kind == Kind::element);
  if (!is_drawn || column.column.is_own) return;
  row.quantity = quantity;
  for (std::size_t k = 0; k < column.values.size(); ++k) {
    if (std::isnan(column.values[k])) continue;
    row.times.push_back(reference.times[k]);
    row.values.push_back(column.values[k]);
  }
}

void note_unstated_errors(const Reference& reference, Verdict& verdict) {
  const auto unstated = std::count_if(reference.columns.begin(), reference.columns.end(),
                                      [](const ReferenceColumn& column) { return !column.is_stated; });
  if (unstated == 0) return;
  verdict.notes.push_back(fmt::format(
      "reference: {} of {} columns state no error: half of the last digit that is written is taken, at most "
      "0.1 % of the peak in the reference; state another by a line such as `# error = 1 %`",
      unstated, reference.columns.size()));
}

void judge_column(const Model& model, const ChosenTimes& times, const ReferenceColumn& column, double largest,
                  ReferenceRow& row) {
  const Reference& reference = times.reference;
  const RunsAtTimes& runs = times.runs;
  row.of = describe_owner(model, column.column);
  row.component = describe_component(column.column);
  row.unit = column.column.unit;
  row.is_judged = times.is_judged;
  row.allowed = std::max(error_of(column, runs.verdict, reference, largest), left_open(runs, column.column, largest));
  measure_row(runs, reference, column, row);
  if (is_off(row)) row.hint = what_would_fit(model, runs, reference, column, row.allowed);
}

}  // namespace

void check_times(const Reference& reference, const RunOptions& run) {
  samples_at(reference, run.until, static_cast<std::size_t>(run.samples));
}

void judge_reference(const Model& model, const Reference& whole, Verdict& verdict) {
  verdict.reference_file = std::filesystem::path(whole.file).filename().string();
  if (!verdict.trajectories[0] || !verdict.trajectories[1]) return;  // a failure already
  const Trajectory& run = *verdict.trajectories[0];
  Reference as_named = whole;
  RunsAtTimes runs{verdict, samples_at(as_named, run.samples.back().state.t, run.samples.size() - 1)};
  cut_at_horizon(run, as_named, runs.samples, verdict);
  const Reference reference = in_stated_convention(model, as_named);
  note_rounded_times(reference, run, runs.samples, verdict);
  note_unstated_errors(reference, verdict);
  std::map<std::string, double> largest = largest_numbers(model, run);
  const std::optional<Trajectory> known =
      verdict.unique ? unique_part(model, run, *verdict.unique) : std::optional<Trajectory>();
  for (std::size_t k = 0; k < reference.columns.size(); ++k) {
    const ChosenTimes times = choose_times(reference, runs, k, known ? *known : run);
    const ReferenceColumn& column = times.reference.columns[times.column];
    ReferenceRow row;
    keep_for_pictures(reference, reference.columns[k], row);
    judge_column(model, times, column, largest[column.column.unit], row);
    verdict.references.push_back(std::move(row));
  }
  const bool is_convention = find_conventions(model, runs, as_named, known ? *known : run, verdict);
  for (const ReferenceRow& row : verdict.references) {
    if (is_off(row)) add_finding(row, verdict);
  }
  if (verdict.outcome != Outcome::agree) return;
  if (std::none_of(verdict.references.begin(), verdict.references.end(),
                   [](const ReferenceRow& row) { return row.is_judged; })) {
    verdict.outcome = Outcome::failed;
    verdict.failures.emplace_back(
        "reference: nothing of it is judged: no component is unique, or no time within reach");
  } else if (std::any_of(verdict.references.begin(), verdict.references.end(), is_off)) {
    verdict.outcome = Outcome::differ;
    if (!is_convention) blame_statement(verdict);
  }
}

}  // namespace concord::compare
