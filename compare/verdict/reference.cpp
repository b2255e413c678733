#include "compare/verdict/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/error.h"
#include "compare/quantities/columns.h"
#include "compare/resolution/unique_part.h"
#include "compare/verdict/reference_convention.h"
#include "compare/verdict/reference_errors.h"
#include "compare/verdict/reference_rows.h"

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

void add_finding(const ReferenceRow& row, Verdict& verdict) {
  const std::string unit = row.unit == "1" ? "" : " " + row.unit;
  verdict.findings.push_back(
      {fmt::format("{}, {}, against the reference: off by {:.3g} (cartesian) and {:.3g} (relative){} at t = {:.4g} s, "
                   "where it says {:.6g}{} (line {}), error {:.3g}",
                   row.of, row.component, row.differences[0], row.differences[1], unit, row.t, row.stated, unit,
                   row.line, row.allowed),
       fmt::format("reference: {}{}{}", verdict.reference_file, row.hint.empty() ? "" : "; ", row.hint)});
}

/// Wrong rows one by one, and together those that are one of infinitely many.
void add_findings(const Standard& standard, const Reference& reference, Verdict& verdict) {
  std::size_t of_many = 0;
  for (std::size_t k = 0; k < verdict.references.size(); ++k) {
    ReferenceRow& row = verdict.references[k];
    if (row.word == ReferenceWord::one_of_many) ++of_many;
    if (row.word != ReferenceWord::wrong) continue;
    if (row.hint.empty()) row.hint = hint_at_wrong(standard, reference, k, row.allowed);
    add_finding(row, verdict);
  }
  if (of_many == 0) return;
  verdict.findings.push_back(
      {fmt::format("reference: {} of {} columns are {}: they are not unique, and the machine's self-stresses explain "
                   "together at each time how far they differ",
                   of_many, verdict.references.size(), to_string(ReferenceWord::one_of_many)),
       fmt::format("reference: {}; `nan` in their place says nothing there", verdict.reference_file)});
}

/// Solvers and audit agree, and the reference does not: what all three are told is wrong, or the reference.
void blame_statement(Verdict& verdict) {
  const auto excess = [](const ReferenceRow& row) {
    const bool is_wrong = row.word == ReferenceWord::wrong;
    return is_wrong ? std::max(row.differences[0], row.differences[1]) / row.allowed : 0.0;
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

void note_unstated_errors(const Reference& reference, double drift, Verdict& verdict) {
  const auto unstated = std::count_if(reference.columns.begin(), reference.columns.end(),
                                      [](const ReferenceColumn& column) { return !column.is_stated; });
  if (unstated == 0) return;
  const std::string out_of_balance =
      drift > 1e-9
          ? fmt::format("; from an equal start it drifts out of balance, and {:.2g} of the peak is taken", drift)
          : "";
  verdict.notes.push_back(fmt::format(
      "reference: {} of {} columns state no error: half of the last digit that is written is taken, or what both runs "
      "differ by, at least 1e-9 and at most 1e-3 of the peak in the reference{}; state another by a line such as `# "
      "error = 1 %`",
      unstated, reference.columns.size(), out_of_balance));
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
  std::vector<std::size_t> samples = samples_at(as_named, run.samples.back().state.t, run.samples.size() - 1);
  cut_at_horizon(run, as_named, samples, verdict);
  note_rounded_times(as_named, run, samples, verdict);
  const std::optional<Trajectory> known =
      verdict.unique ? unique_part(model, run, *verdict.unique) : std::optional<Trajectory>();
  const Standard standard = standard_of(model, verdict, samples, known ? *known : run);
  const Standard as_stated = re_expressed(standard, as_named.conventions);
  const Reference reference = in_stated_convention(model, as_named);
  JudgedRows judged = judge_rows(as_stated, reference);
  verdict.references = std::move(judged.rows);
  note_unstated_errors(reference, judged.drift, verdict);
  if (judged.left_out > 0) {
    verdict.notes.push_back(
        fmt::format("reference: {} number{} not judged, because it is not clear whether the component is unique there",
                    judged.left_out, judged.left_out == 1 ? " is" : "s are"));
  }
  find_conventions(standard, as_named, verdict);
  add_findings(as_stated, reference, verdict);
  if (verdict.outcome != Outcome::agree) return;
  const auto has = [&](ReferenceWord word) {
    return std::any_of(verdict.references.begin(), verdict.references.end(),
                       [word](const ReferenceRow& row) { return row.word == word; });
  };
  if (std::any_of(verdict.references.begin(), verdict.references.end(), is_off)) {
    verdict.outcome = Outcome::differ;
    if (has(ReferenceWord::wrong)) blame_statement(verdict);
  } else if (!has(ReferenceWord::equal)) {
    verdict.outcome = Outcome::failed;
    verdict.failures.emplace_back(
        "reference: nothing of it is judged: no component is unique, or no time within reach");
  }
}

}  // namespace concord::compare
