#include "compare/report/peaks.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "compare/audit/carried_components.h"
#include "compare/report/told_axes.h"
#include "compare/resolution/unique_part.h"

namespace concord::compare {

const Wrench& wrench_of(const Quantity& of, const Sample& sample) {
  const auto owner = static_cast<std::size_t>(of.owner);
  return of.kind == Kind::element ? sample.evaluation.elements.at(owner).on_side(of.side).in_C
                                  : sample.evaluation.joints.at(owner).reaction_on(of.side).in_C;
}

namespace {

constexpr std::array kComponents{0, 1, 2, 3, 4, 5};  // of a wrench

/// What of a run is looked at: its samples, and where quantities are unique.
struct Looked {
  const Trajectory& run;
  const Mask* unique;
  bool is_turned;  // into axes that are not those of the sides

  [[nodiscard]] bool is_open(int row, std::size_t sample) const {
    return unique != nullptr && !(*unique)(row, static_cast<Eigen::Index>(sample));
  }
  [[nodiscard]] bool is_mostly_open(int row) const {
    std::size_t open = 0;
    for (std::size_t k = 0; k < run.samples.size(); ++k) open += is_open(row, k) ? 1 : 0;
    return 2 * open > run.samples.size();
  }
};

/// The peak of a number over the samples in which all of `rows` are unique; missing where there are none.
std::optional<Peak> peak_of(const Looked& looked, const std::vector<int>& rows,
                            const std::function<double(const Sample&)>& value) {
  constexpr double kAsLarge = 1e-6;
  std::vector<Peak> values;
  double largest = 0.0;
  double squares = 0.0;
  for (std::size_t k = 0; k < looked.run.samples.size(); ++k) {
    if (std::any_of(rows.begin(), rows.end(), [&](int row) { return looked.is_open(row, k); })) continue;
    const Sample& sample = looked.run.samples[k];
    values.push_back({value(sample), sample.state.t, 0.0});
    largest = std::max(largest, std::abs(values.back().value));
    squares += values.back().value * values.back().value;
  }
  const auto first = std::find_if(values.begin(), values.end(),
                                  [&](const Peak& one) { return std::abs(one.value) >= (1.0 - kAsLarge) * largest; });
  if (first == values.end()) return {};
  first->root_mean_square = std::sqrt(squares / static_cast<double>(values.size()));
  return *first;
}

/// |F| (part 0) or |T| (part 1) of the wrench whose first row is `first`.
ForcePeak part_of(const Model& model, const Quantity& of, int first, int part, const Looked& looked) {
  ForcePeak found;
  std::vector<int> components;
  bool is_whole = true;
  const auto is_carried = [&](int c) {
    return of.kind == Kind::element || carries(*model.joints[static_cast<std::size_t>(of.owner)].type, of.side, c);
  };
  const bool carries_part = is_carried(3 * part) || is_carried(3 * part + 1) || is_carried(3 * part + 2);
  for (int c = 3 * part; c < 3 * part + 3; ++c) {
    if (!(looked.is_turned ? carries_part : is_carried(c))) continue;
    found.exists = true;
    if (looked.is_mostly_open(first + c)) {
      is_whole = false;
    } else {
      components.push_back(c);
    }
  }
  if (components.empty()) return found;
  std::vector<int> rows;
  for (const int c : components) {
    const auto one = [&, c](const Sample& sample) { return wrench_of(of, sample).vector()(c); };
    if (looked.is_turned) found.components.at(static_cast<std::size_t>(c % 3)) = peak_of(looked, {first + c}, one);
    rows.push_back(first + c);
    if (!is_whole) found.axes += "xyz"[c % 3];
  }
  found.value = peak_of(looked, rows, [&](const Sample& sample) {
    const Vec6 wrench = wrench_of(of, sample).vector();
    double squares = 0.0;
    for (const int c : components) squares += wrench(c) * wrench(c);
    return std::sqrt(squares);
  });
  return found;
}

double force_of(const Quantity& of, const Sample& sample) {
  const auto owner = static_cast<std::size_t>(of.owner);
  if (of.kind == Kind::coupling) return sample.evaluation.couplings.at(owner);
  const JointWrenches& joint = sample.evaluation.joints.at(owner);
  return (of.kind == Kind::tau ? joint.tau : joint.share_of(of.actor))(of.component);
}

/// Force and power of an actor, or force of a coupling.
std::array<ForcePeak, 2> parts_along(const Quantity& of, int row, const Looked& looked) {
  std::array<ForcePeak, 2> parts;
  parts[0] = {true, "", peak_of(looked, {row}, [&](const Sample& sample) { return force_of(of, sample); })};
  if (of.kind == Kind::coupling) return parts;
  const auto owner = static_cast<std::size_t>(of.owner);
  parts[1] = {true, "", peak_of(looked, {row}, [&](const Sample& sample) {
                return force_of(of, sample) * sample.state.u.at(owner)(of.component);
              })};
  return parts;
}

bool carries_any(const Model& model, const Quantity& of) {
  if (of.kind == Kind::element) return true;
  const joints::JointType& type = *model.joints[static_cast<std::size_t>(of.owner)].type;
  return std::any_of(kComponents.begin(), kComponents.end(), [&](int c) { return carries(type, of.side, c); });
}

/// What a row of the layout is the first of: a wrench that is told, or a force along a coordinate.
bool is_told(const Model& model, const Quantity& of) {
  if (of.kind == Kind::reaction || of.kind == Kind::element) return of.component == 0 && carries_any(model, of);
  return is_told_force(model, of);
}

/// Peaks below what the digits of the machine's largest force resolve are zero, from the first sample on.
void drop_round_off(const Model& model, const Trajectory& run, std::vector<ForcePeaks>& all) {
  constexpr double kRoundOff = 1e-14;
  double force = 0.0;
  double torque = 0.0;
  for (const ForcePeaks& row : all) {
    if (is_scalar_force(row.of.kind)) continue;
    if (row.parts[0].value) force = std::max(force, row.parts[0].value->value);
    if (row.parts[1].value) torque = std::max(torque, row.parts[1].value->value);
  }
  torque = std::max(torque, force * model.length_scale());
  const auto drop = [&](ForcePeak& part, double largest) {
    const auto drop_one = [&](std::optional<Peak>& peak) {
      if (peak && std::abs(peak->value) <= kRoundOff * largest) peak = Peak{0.0, run.samples.front().state.t, 0.0};
    };
    drop_one(part.value);
    for (std::optional<Peak>& component : part.components) drop_one(component);
  };
  for (ForcePeaks& row : all) {
    if (!is_scalar_force(row.of.kind)) {
      drop(row.parts[0], force);
      drop(row.parts[1], torque);
    } else if (const std::string unit = unit_of(model, row.of); unit == "N" || unit == "N m") {
      drop(row.parts[0], unit == "N" ? force : torque);
    }
  }
}

}  // namespace

ToldRun told_in(const QuantityLayout& layout, const Trajectory& run, const Mask* unique, int axes) {
  const Model& model = layout.model();
  const std::optional<Trajectory> known = unique != nullptr ? unique_part(model, run, *unique) : std::nullopt;
  ToldRun told{told_run(model, known ? *known : run, axes), {}};
  const auto samples = static_cast<Eigen::Index>(run.samples.size());
  told.unique = unique != nullptr
                    ? *unique
                    : Mask::Constant(static_cast<Eigen::Index>(layout.quantities().size()), samples, true);
  for (int row = 0; row < static_cast<int>(layout.quantities().size()); ++row) {
    const Quantity& of = layout.quantities()[static_cast<std::size_t>(row)];
    if (of.kind != Kind::reaction) continue;
    for (Eigen::Index k = 0; k < samples; ++k) {
      const Wrench& wrench = wrench_of(of, told.run.samples[static_cast<std::size_t>(k)]);
      told.unique(row, k) = !std::isnan(wrench.vector()(of.component));
    }
  }
  return told;
}

std::vector<ForcePeaks> force_peaks(const QuantityLayout& layout, const Trajectory* run, const Mask* unique,
                                    std::optional<int> axes) {
  const Model& model = layout.model();
  std::optional<ToldRun> told;
  if (axes && run != nullptr) {
    told = told_in(layout, *run, unique, *axes);
    run = &told->run;
    unique = &told->unique;
  }
  std::vector<ForcePeaks> all;
  for (int row = 0; row < static_cast<int>(layout.quantities().size()); ++row) {
    const Quantity& of = layout.quantities()[static_cast<std::size_t>(row)];
    if (!is_told(model, of)) continue;
    ForcePeaks& peaks = all.emplace_back(ForcePeaks{of, {}});
    if (run == nullptr) continue;
    const Looked looked{*run, unique, axes.has_value()};
    if (!is_scalar_force(of.kind)) {
      for (int part = 0; part < 2; ++part) {
        peaks.parts[static_cast<std::size_t>(part)] = part_of(model, of, row, part, looked);
      }
    } else {
      peaks.parts = parts_along(of, row, looked);
    }
  }
  if (run != nullptr) drop_round_off(model, *run, all);
  return all;
}

}  // namespace concord::compare
