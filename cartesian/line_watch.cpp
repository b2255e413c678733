#include "cartesian/line_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/error.h"

namespace concord::cartesian {

namespace {

bool has_gone_through(const SpringLine& before, const SpringLine& now) {
  constexpr double kOblique = 0.5;  // cosine of line and rate
  const auto is_oblique = [](const SpringLine& at, double sign) {
    return sign * at.span.dot(at.rate) < kOblique * at.span.norm() * at.rate.norm();
  };
  return now.span.dot(before.span) <= 0.0 && !is_oblique(before, -1.0) && !is_oblique(now, 1.0);
}

/// Whether the ends have come together in between and gone apart again on the same side. The way of one about the other
/// is taken for Bezier's cubic, which is good to a small part of the way of a step; its nearest point is sought by
/// cutting off thirds.
bool has_touched(const SpringLine& before, const SpringLine& now, double step, double length) {
  constexpr double kTouch = 1e-6;        // of the machine's length
  constexpr double kPartOfSpans = 1e-3;  // of the shorter span
  constexpr int kCuts = 80;
  if (before.span.dot(before.rate) > 0.0 || now.span.dot(now.rate) < 0.0) return false;
  const Vec3 leaves = before.span + step / 3.0 * before.rate;
  const Vec3 arrives = now.span - step / 3.0 * now.rate;
  const auto span_at = [&](double part) {
    const double rest = 1.0 - part;
    const Vec3 way = rest * rest * rest * before.span + 3.0 * rest * rest * part * leaves +
                     3.0 * rest * part * part * arrives + part * part * part * now.span;
    return way.norm();
  };
  double from = 0.0;
  double to = 1.0;
  for (int cut = 0; cut < kCuts; ++cut) {
    const double third = (to - from) / 3.0;
    if (span_at(from + third) < span_at(to - third)) {
      to -= third;
    } else {
      from += third;
    }
  }
  const double shorter = std::min(before.span.norm(), now.span.norm());
  const double allowed = std::min(kTouch * length, std::max(kPartOfSpans * shorter, 0.1 * kTouch * length));
  return span_at(0.5 * (from + to)) <= allowed;
}

}  // namespace

LineWatch::LineWatch(double t, const AppliedForces& applied, double length)
    : t_(t), length_(length), lines_(applied.spring_lines(t)) {}

void LineWatch::follow(double t, const AppliedForces& applied) {
  if (lines_.empty()) return;
  std::vector<SpringLine> now = applied.spring_lines(t);
  for (std::size_t k = 0; k < now.size(); ++k) {
    if (!has_gone_through(lines_[k], now[k]) && !has_touched(lines_[k], now[k], t - t_, length_)) continue;
    if (!now[k].is_reversed_with_a_jump && !lines_[k].is_reversed_with_a_jump) continue;
    throw SolverError(
        fmt::format("cartesian: at t = {:.6g} s the ends of line spring '{}' have met since t = {:.9g} s: its force "
                    "has no direction there",
                    t, *now[k].name, t_));
  }
  t_ = t;
  lines_ = std::move(now);
}

}  // namespace concord::cartesian
