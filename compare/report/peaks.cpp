#include "compare/report/peaks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "compare/audit/joint_motion.h"
#include "compare/quantities/observe.h"
#include "compare/report/text_table.h"

namespace concord::compare {

namespace {

using Lines = std::vector<std::vector<std::string>>;

/// A number over the samples in which it is unique.
class Course {
 public:
  void add(double value, double t) {
    values_.push_back(value);
    times_.push_back(t);
  }
  [[nodiscard]] bool empty() const { return values_.empty(); }
  /// The first value whose size is within 1e-6 of the largest, and its time.
  [[nodiscard]] std::pair<double, double> peak() const {
    constexpr double kAsLarge = 1e-6;
    double largest = 0.0;
    for (const double value : values_) largest = std::max(largest, std::abs(value));
    std::size_t k = 0;
    while (!(std::abs(values_[k]) >= (1.0 - kAsLarge) * largest)) ++k;
    return {values_[k], times_[k]};
  }
  [[nodiscard]] double root_mean_square() const {
    double squares = 0.0;
    for (const double value : values_) squares += value * value;
    return std::sqrt(squares / static_cast<double>(values_.size()));
  }

 private:
  std::vector<double> values_;
  std::vector<double> times_;
};

std::string number(double value) { return fmt::format("{:.6g}", value); }

void add_peak(const Course& course, std::vector<std::string>& line) {
  if (course.empty()) {
    line.insert(line.end(), {"not unique", "-"});
    return;
  }
  const auto [value, t] = course.peak();
  line.push_back(number(value));
  line.push_back(number(t));
}

bool is_open(const Mask* unique, int row, std::size_t sample) {
  return unique != nullptr && !(*unique)(row, static_cast<Eigen::Index>(sample));
}

/// |F| and |T| of a reaction.
std::array<Course, 2> courses_of(const QuantityLayout& layout, int joint, Side side, const Trajectory& run,
                                 const Mask* unique) {
  const int first = layout.first_row(Kind::reaction, joint, side);
  std::array<Course, 2> courses;
  for (std::size_t k = 0; k < run.samples.size(); ++k) {
    const Sample& sample = run.samples[k];
    const Wrench& wrench = sample.evaluation.joints.at(static_cast<std::size_t>(joint)).reaction_on(side).in_C;
    for (int part = 0; part < 2; ++part) {
      const std::array rows{first + 3 * part, first + 3 * part + 1, first + 3 * part + 2};
      if (std::any_of(rows.begin(), rows.end(), [&](int row) { return is_open(unique, row, k); })) continue;
      courses[static_cast<std::size_t>(part)].add((part == 0 ? wrench.force : wrench.torque).norm(), sample.state.t);
    }
  }
  return courses;
}

/// Of a force along a coordinate, or of a coupling, and the power that it delivers.
struct DriveCourses {
  Course force;
  Course power;
};

DriveCourses courses_of(const Quantity& drive, int row, const Trajectory& run, const Mask* unique) {
  const auto owner = static_cast<std::size_t>(drive.owner);
  DriveCourses courses;
  for (std::size_t k = 0; k < run.samples.size(); ++k) {
    if (is_open(unique, row, k)) continue;
    const auto& [state, evaluation, work] = run.samples[k];
    if (drive.kind == Kind::coupling) {
      courses.force.add(evaluation.couplings.at(owner), state.t);
      continue;
    }
    const JointWrenches& joint = evaluation.joints.at(owner);
    const double force = (drive.kind == Kind::tau ? joint.tau : joint.share_of(drive.actor))(drive.component);
    courses.force.add(force, state.t);
    courses.power.add(force * state.u.at(owner)(drive.component), state.t);
  }
  return courses;
}

/// "turn_z" of the joint's speed.
std::string coordinate_of(const Model& model, const Quantity& drive) {
  const joints::JointType& type = *model.joints[static_cast<std::size_t>(drive.owner)].type;
  return speed_names(type).at(static_cast<std::size_t>(drive.component));
}

}  // namespace

std::string format_peaks(const Model& model, const Trajectory& run, const Mask* unique) {
  const QuantityLayout layout(model);
  Lines lines{{"joint", "on", "peak F [N]", "at t [s]", "peak T [N m]", "at t [s]"}};
  for (int k = 0; k < static_cast<int>(model.joints.size()); ++k) {
    const Joint& joint = model.joints[static_cast<std::size_t>(k)];
    for (const Side side : kSides) {
      std::vector<std::string> line{joint.name, model.bodies[static_cast<std::size_t>(joint.on(side).body)].name};
      for (const Course& course : courses_of(layout, k, side, run, unique)) add_peak(course, line);
      lines.push_back(std::move(line));
    }
  }
  const std::string drives = format_drives(model, run, unique);
  return format_table(lines, {false, false, true, true, true, true}) + (drives.empty() ? "" : '\n' + drives);
}

std::string format_drives(const Model& model, const Trajectory& run, const Mask* unique) {
  const QuantityLayout layout(model);
  Lines lines{{"force", "along", "largest", "at t [s]", "RMS", "power [W]", "at t [s]"}};
  for (int row = 0; row < static_cast<int>(layout.quantities().size()); ++row) {
    const Quantity& drive = layout.quantities()[static_cast<std::size_t>(row)];
    const bool is_sum = drive.kind == Kind::tau && is_shared(model, drive.owner, drive.component);
    if (!is_scalar_force(drive.kind) || is_sum) continue;
    const DriveCourses courses = courses_of(drive, row, run, unique);
    const bool is_coupling = drive.kind == Kind::coupling;
    std::vector<std::string> line{describe_owner(model, drive), is_coupling ? "-" : coordinate_of(model, drive)};
    add_peak(courses.force, line);
    line.push_back(courses.force.empty() ? "-" : number(courses.force.root_mean_square()));
    if (!courses.force.empty()) line[2] += ' ' + unit_of(model, drive);
    if (is_coupling || courses.power.empty()) {
      line.insert(line.end(), {"-", "-"});
    } else {
      add_peak(courses.power, line);
    }
    lines.push_back(std::move(line));
  }
  if (lines.size() == 1) return "";
  return format_table(lines, {false, false, true, true, true, true, true});
}

}  // namespace concord::compare
