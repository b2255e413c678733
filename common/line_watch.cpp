#include "common/line_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/error.h"

namespace concord {

namespace {

/// The line turns over, and its ends come towards each other before and go apart behind: within 60 deg of the line, so
/// that a spring which turns with a fast part, as from an axis to a rim, is not meant.
bool pass_each_other(const SpringLine& begin, const SpringLine& end) {
  constexpr double kAlong = 0.5;  // cosine of line and rate
  const auto least = [](const SpringLine& at) { return kAlong * at.span.norm() * at.rate.norm(); };
  return begin.span.dot(end.span) <= 0.0 && begin.span.dot(begin.rate) <= -least(begin) &&
         end.span.dot(end.rate) >= least(end);
}

/// Whether the ends come so near to each other within the step that they meet, as a point does that turns round there:
/// by a cubic through the lines and their rates at both ends. It is known to a small part of the step's own way only.
bool touch_each_other(const SpringLine& begin, const SpringLine& end, double h, double length) {
  constexpr double kNearest = 1e-6;        // of the machine's length
  constexpr double kPartOfTheStep = 1e-3;  // of the distance at the ends of the step
  constexpr double kGolden = 0.3819660112501051;
  constexpr int kSections = 50;
  if (begin.span.dot(begin.rate) > 0.0 || end.span.dot(end.rate) < 0.0) return false;
  const auto distance = [&](double s) {
    const double value = s * s * (3.0 - 2.0 * s);
    const Vec3 slopes = (1.0 - s) * begin.rate - s * end.rate;
    return ((1.0 - value) * begin.span + value * end.span + h * s * (1.0 - s) * slopes).norm();
  };
  double low = 0.0;
  double high = 1.0;
  for (int k = 0; k < kSections; ++k) {
    const double left = low + kGolden * (high - low);
    const double right = high - kGolden * (high - low);
    (distance(left) < distance(right) ? high : low) = distance(left) < distance(right) ? right : left;
  }
  const double resolved = kPartOfTheStep * std::min(begin.span.norm(), end.span.norm());
  const double allowed = std::clamp(resolved, 0.1 * kNearest * length, kNearest * length);
  return distance(0.5 * (low + high)) <= allowed;
}

}  // namespace

void LineWatch::pass(double t, std::vector<SpringLine> lines) {
  while (!last_.empty() && last_.back().t >= t) last_.pop_back();
  settle();
  last_.push_back({t, std::move(lines)});
}

void LineWatch::settle() {
  if (last_.size() < 2) return;
  const Record& begin = last_.front();
  const Record& end = last_.back();
  for (std::size_t k = 0; k < end.lines.size(); ++k) {
    const SpringLine& before = begin.lines[k];
    const SpringLine& after = end.lines[k];
    if (!before.is_reversed_with_a_jump && !after.is_reversed_with_a_jump) continue;
    if (!pass_each_other(before, after) && !touch_each_other(before, after, end.t - begin.t, length_)) continue;
    throw SolverError(
        fmt::format("{}: at t = {:.6g} s the ends of line spring '{}' have met since t = {:.9g} s: its force has no "
                    "direction there",
                    solver_, end.t, *after.name, begin.t));
  }
  last_.erase(last_.begin());
}

}  // namespace concord
