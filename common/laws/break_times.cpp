#include "common/laws/break_times.h"

#include <algorithm>

#include "common/overloaded.h"

namespace concord {

namespace {

constexpr double kSameTime = 1e-12;  // of the run

void add_to(std::vector<double>& times, const TimeFunction& law) {
  const std::vector<double> more = break_times(law);
  times.insert(times.end(), more.begin(), more.end());
}

void add_to(std::vector<const TimeFunction*>& laws, const ForceLaw& law) {
  if (law.actuator) laws.push_back(&*law.actuator);
}

void add_to(std::vector<const TimeFunction*>& laws, const ForceElement& element) {
  each_quantity(
      element,
      Overloaded{elements::IgnoreQuantity{},
                 [&](const elements::FactorOverTime<const TimeFunction>& factor) { laws.push_back(&factor.value); },
                 [&](const elements::LawOverCoordinate<const ForceLaw>& spring) { add_to(laws, spring.value); }});
}

/// Of drivers, actuators and loads.
std::vector<const TimeFunction*> laws_of_time(const Model& model) {
  std::vector<const TimeFunction*> laws;
  for (const Joint& joint : model.joints) {
    for (const Driver& driver : joint.drivers) laws.push_back(&driver.law);
    for (const JointSpring& spring : joint.springs) add_to(laws, spring.law);
  }
  for (const ForceElement& element : model.elements) add_to(laws, element);
  return laws;
}

bool is_constant(const TimeFunction& law) {
  const auto* steady = std::get_if<ConstantSpeed>(&law);
  return steady != nullptr && steady->speed == 0.0;
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
  for (const TimeFunction* law : laws_of_time(model)) add_to(times, *law);
  std::sort(times.begin(), times.end());
  const double close = kSameTime * until;
  std::vector<double> within;
  for (const double t : times) {
    if (t <= close || t >= until - close) continue;
    if (within.empty() || t - within.back() > close) within.push_back(t);
  }
  return within;
}

bool has_laws_of_time(const Model& model) {
  const std::vector<const TimeFunction*> laws = laws_of_time(model);
  return std::any_of(laws.begin(), laws.end(), [](const TimeFunction* law) { return !is_constant(*law); });
}

}  // namespace concord
