#include "relative/line_watch.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/error.h"

namespace concord::relative {

namespace {

/// The line turns over, and its ends come towards each other before and go apart behind: within 60 deg of the line, so
/// that a spring which turns with a fast part, as from an axis to a rim, is not meant.
bool pass_each_other(const LineState& begin, const LineState& end) {
  constexpr double kAlong = 0.5;
  const auto range_rate = [](const LineState& at) { return at.line.dot(at.velocity); };
  const auto least = [](const LineState& at) { return kAlong * at.line.norm() * at.velocity.norm(); };
  return begin.line.dot(end.line) <= 0.0 && range_rate(begin) <= -least(begin) && range_rate(end) >= least(end);
}

}  // namespace

namespace {

/// Whether the ends come so near to each other within the step that they meet, as a point does that turns round there:
/// by a cubic through the lines and their rates at both ends. It is known to a small part of the step's own way only.
bool touch_each_other(const LineState& begin, const LineState& end, double h, double length) {
  constexpr double kNearest = 1e-6;        // of the machine's length
  constexpr double kPartOfTheStep = 1e-3;  // of the distance at the ends of the step
  constexpr double kGolden = 0.3819660112501051;
  constexpr int kSections = 50;
  if (begin.line.dot(begin.velocity) > 0.0 || end.line.dot(end.velocity) < 0.0) return false;
  const auto distance = [&](double s) {
    const double value = s * s * (3.0 - 2.0 * s);
    const Vec3 slopes = (1.0 - s) * begin.velocity - s * end.velocity;
    return ((1.0 - value) * begin.line + value * end.line + h * s * (1.0 - s) * slopes).norm();
  };
  double low = 0.0;
  double high = 1.0;
  for (int k = 0; k < kSections; ++k) {
    const double left = low + kGolden * (high - low);
    const double right = high - kGolden * (high - low);
    (distance(left) < distance(right) ? high : low) = distance(left) < distance(right) ? right : left;
  }
  const double resolved = kPartOfTheStep * std::min(begin.line.norm(), end.line.norm());
  const double allowed = std::clamp(resolved, 0.1 * kNearest * length, kNearest * length);
  return distance(0.5 * (low + high)) <= allowed;
}

}  // namespace

void LineWatch::pass(double t, const AppliedForces& forces) {
  while (!last_.empty() && last_.back().t >= t) last_.pop_back();
  settle();
  last_.push_back({t, forces.lines(t)});
}

void LineWatch::settle() {
  if (last_.size() < 2) return;
  const Record& begin = last_.front();
  const Record& end = last_.back();
  for (std::size_t k = 0; k < end.lines.size(); ++k) {
    const LineState& before = begin.lines[k];
    const LineState& after = end.lines[k];
    if (!pass_each_other(before, after) && !touch_each_other(before, after, end.t - begin.t, length_)) continue;
    if (before.jump == 0.0 && after.jump == 0.0) continue;
    throw SolverError(
        fmt::format("relative: force element '{}': its ends meet between t = {:.9g} s and {:.9g} s, so that its force "
                    "has no direction there",
                    *end.lines[k].name, begin.t, end.t));
  }
  last_.erase(last_.begin());
}

}  // namespace concord::relative
