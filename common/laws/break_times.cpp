#include "common/laws/break_times.h"

#include <algorithm>

namespace concord {

namespace {

constexpr double kSameTime = 1e-12;  // of the run

void add_to(std::vector<double>& times, const TimeFunction& law) {
  const std::vector<double> more = break_times(law);
  times.insert(times.end(), more.begin(), more.end());
}

void add_to(std::vector<double>& times, const ForceLaw& law) {
  if (law.actuator) add_to(times, *law.actuator);
}

void add_to(std::vector<double>& times, const ForceElement& element) {
  if (const auto* load = std::get_if<Load>(&element.what)) add_to(times, load->law);
  if (const auto* spring = std::get_if<LineSpring>(&element.what)) add_to(times, spring->law);
  if (const auto* spring = std::get_if<TurnSpring>(&element.what)) add_to(times, spring->law);
}

}  // namespace

std::vector<double> break_times(const TimeFunction& law) {
  if (const auto* step = std::get_if<SmoothStep>(&law)) return {step->t0, step->t1};
  if (const auto* table = std::get_if<SplineTable>(&law)) {
    // By the not-a-knot condition the second knot and the last but one are none.
    const std::vector<double>& times = table->times();
    if (times.size() > 4) return {times.begin() + 2, times.end() - 2};
  }
  return {};
}

std::vector<double> break_times(const Model& model, double until) {
  std::vector<double> times;
  for (const Joint& joint : model.joints) {
    for (const Driver& driver : joint.drivers) add_to(times, driver.law);
    for (const JointSpring& spring : joint.springs) add_to(times, spring.law);
  }
  for (const ForceElement& element : model.elements) add_to(times, element);
  std::sort(times.begin(), times.end());
  const double close = kSameTime * until;
  std::vector<double> within;
  for (const double t : times) {
    if (t <= close || t >= until - close) continue;
    if (within.empty() || t - within.back() > close) within.push_back(t);
  }
  return within;
}

}  // namespace concord
