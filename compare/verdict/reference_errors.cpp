#include "compare/verdict/reference_errors.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "compare/quantities/columns.h"

namespace concord::compare {

namespace {

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

/// How many numbers belong together with a column's, as the components of one vector.
int size_of_vector(Field field) {
  switch (field) {
    case Field::euler_parameter:
      return 4;
    case Field::modal_coordinate:
    case Field::modal_velocity:
    case Field::modal_acceleration:
    case Field::joint_coordinate:
    case Field::tau:
    case Field::share:
    case Field::coupling:
      return 1;
    default:
      return 3;
  }
}

/// Largest length of the vector that the column is a component of, over the run up to `last` [s]; of a number alone its
/// largest size.
double peak_of(const Column& column, const Trajectory& run, double last) {
  const int size = size_of_vector(column.field);
  Column part = column;
  double peak = 0.0;
  for (const Sample& sample : run.samples) {
    if (sample.state.t > last) break;
    double square = 0.0;
    for (int c = 0; c < size; ++c) {
      part.component = column.component / size * size + c;
      square += std::pow(value_of(part, sample), 2);
    }
    peak = std::max(peak, std::sqrt(square));
  }
  return peak;
}

/// Whether two columns are components of one vector, or one number.
bool are_of_one_vector(const Column& one, const Column& other) {
  const int size = size_of_vector(one.field);
  return one.field == other.field && one.is_own == other.is_own && one.owner == other.owner && one.side == other.side &&
         one.component / size == other.component / size;
}

/// The same as the reference says it: largest length of the components that it has of the column's vector.
double peak_of(const Column& column, const Reference& reference) {
  double peak = 0.0;
  for (std::size_t k = 0; k < reference.times.size(); ++k) {
    double square = 0.0;
    for (const ReferenceColumn& other : reference.columns) {
      if (are_of_one_vector(other.column, column) && !std::isnan(other.values[k]))
        square += std::pow(other.values[k], 2);
    }
    peak = std::max(peak, std::sqrt(square));
  }
  return peak;
}

/// What a stated error in percent is a part of: the peak of the column's vector in the run or in the reference,
/// whichever is larger. One that is next to nothing beside what the table takes for scale, or of what moves beside the
/// machine's `largest` number of its unit, is measured against that: the place of a body whose origin is a hinge on the
/// ground.
double measure_of_percent(const Column& column, const Verdict& verdict, const Reference& reference, double largest) {
  constexpr double kNextToNothing = 1e-4;
  if (has_free_sign(column)) return 1.0;
  const auto quantity = quantity_of(column);
  const double peak =
      std::max(peak_of(column, *verdict.trajectories[0], last_judged(verdict)), peak_of(column, reference));
  if (quantity) return std::max(peak, kNextToNothing * scale_of(verdict, *quantity));
  const bool moves = !may_be_open(column);
  return moves ? std::max(peak, kNextToNothing * largest) : peak;
}

/// Zero of nothing.
double lower_median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

constexpr double kMostUnstated = 1e-3;  // of the peak, where no error is stated

/// What the digits of a column leave open where no error is stated: half a unit of the last digit of the peak of its
/// vector, written with as many digits as its longest number, and no less than any run is held to.
double error_of_digits(const ReferenceColumn& column, const Reference& reference) {
  constexpr double kLeast = 1e-9;
  const double peak = peak_of(column.column, reference);
  if (peak == 0.0) return 0.0;
  int digits = 0;
  for (const ReferenceColumn& other : reference.columns) {
    if (are_of_one_vector(other.column, column.column)) digits = std::max(digits, other.digits);
  }
  const double half = 0.5 * std::pow(10.0, std::floor(std::log10(peak)) - digits + 1);
  return std::clamp(half, kLeast * peak, most_unstated(column, reference));
}

}  // namespace

bool has_free_sign(const Column& column) {
  return column.field == Field::euler_parameter || (column.field == Field::joint_coordinate && column.unit == "1");
}

double last_judged(const Verdict& verdict) {
  const double until = verdict.trajectories[0]->samples.back().state.t;
  return verdict.same_run.horizon.value_or(until) +
         kOnGrid * until / static_cast<double>(verdict.trajectories[0]->samples.size());
}

double error_of(const ReferenceColumn& column, const Verdict& verdict, const Reference& reference, double largest,
                double drift) {
  if (!column.is_stated) return std::max(error_of_digits(column, reference), drift * peak_of(column.column, reference));
  return column.error * (column.is_relative ? measure_of_percent(column.column, verdict, reference, largest) : 1.0);
}

double most_unstated(const ReferenceColumn& column, const Reference& reference) {
  return kMostUnstated * peak_of(column.column, reference);
}

double drift_of(const Standard& standard, const Reference& reference) {
  constexpr double kTimes = 10.0;
  constexpr double kNoise = 1e-6;  // of the machine's largest number of that unit
  constexpr std::size_t kFewest = 5;
  const RunsAtTimes& runs = standard.runs;
  if (runs.samples.size() < kFewest || runs.samples.front() != 0) return 0.0;
  std::vector<std::pair<const Column*, std::vector<double>>> deviations;  // of each vector at each time, of its peak
  for (const ReferenceColumn& said : reference.columns) {
    if (said.is_stated || said.column.is_own || has_free_sign(said.column)) continue;
    const double peak = peak_of(said.column, reference);
    if (!(peak > kNoise * size_of(standard, said.column.unit))) continue;
    auto of_vector = std::find_if(deviations.begin(), deviations.end(),
                                  [&](const auto& one) { return are_of_one_vector(*one.first, said.column); });
    if (of_vector == deviations.end()) {
      of_vector = deviations.insert(of_vector, {&said.column, std::vector<double>(runs.samples.size(), 0.0)});
    }
    for (std::size_t k = 0; k < runs.samples.size(); ++k) {
      const double off = std::abs(value_of(said.column, *standard.known[k]) - said.values[k]);
      if (k == 0 && off > error_of_digits(said, reference)) return 0.0;
      double& largest = of_vector->second[k];
      if (off > largest * peak) largest = off / peak;  // not where either says nothing
    }
  }
  std::vector<double> medians;
  for (const auto& [column, of_vector] : deviations) medians.push_back(lower_median(of_vector));
  const double median = lower_median(std::move(medians));
  return median > kMostUnstated ? 0.0 : std::min(kMostUnstated, kTimes * median);
}

}  // namespace concord::compare
