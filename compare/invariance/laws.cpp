#include "compare/invariance/laws.h"

#include <algorithm>

#include "common/overloaded.h"

namespace concord::compare::invariance {

namespace {

std::optional<ForceTable> mirrored_table(const std::optional<ForceTable>& table) {
  if (!table) return {};
  const SplineTable points = scaled(table->points(), -1.0, -1.0);
  return ForceTable(points.times(), points.values());
}

}  // namespace

SplineTable scaled(const SplineTable& table, double x, double y) {
  std::vector<double> xs = table.times();
  std::vector<double> ys = table.values();
  for (double& one : xs) one *= x;
  for (double& one : ys) one *= y;
  if (x < 0.0) {
    std::reverse(xs.begin(), xs.end());
    std::reverse(ys.begin(), ys.end());
  }
  return {xs, ys};
}

TimeFunction scaled(const TimeFunction& law, double value, double time) {
  using Law = TimeFunction;
  return std::visit(
      Overloaded{[&](const ConstantSpeed& one) -> Law {
                   return ConstantSpeed{one.start * value, one.speed * value / time};
                 },
                 [&](Polynomial one) -> Law {
                   double factor = value;
                   for (double& coefficient : one.coefficients) {
                     coefficient *= factor;
                     factor /= time;
                   }
                   return one;
                 },
                 [&](const Harmonic& one) -> Law {
                   return Harmonic{one.offset * value, one.amplitude * value, one.frequency / time, one.phase};
                 },
                 [&](const SmoothStep& one) -> Law {
                   return SmoothStep{one.t0 * time, one.t1 * time, one.from * value, one.to * value};
                 },
                 [&](const SplineTable& one) -> Law { return scaled(one, time, value); }},
      law);
}

TimeFunction shifted(const TimeFunction& law, double by) {
  using Law = TimeFunction;
  return std::visit(Overloaded{[&](const ConstantSpeed& one) -> Law {
                                 return ConstantSpeed{one.start + by, one.speed};
                               },
                               [&](Polynomial one) -> Law {
                                 if (one.coefficients.empty()) one.coefficients = {0.0};
                                 one.coefficients.front() += by;
                                 return one;
                               },
                               [&](Harmonic one) -> Law {
                                 one.offset += by;
                                 return one;
                               },
                               [&](const SmoothStep& one) -> Law {
                                 return SmoothStep{one.t0, one.t1, one.from + by, one.to + by};
                               },
                               [&](const SplineTable& one) -> Law {
                                 std::vector<double> values = one.values();
                                 for (double& value : values) value += by;
                                 return SplineTable(one.times(), values);
                               }},
                    law);
}

ForceLaw mirrored(ForceLaw law) {
  law.free = -law.free;
  law.preload = -law.preload;
  law.spring_table = mirrored_table(law.spring_table);
  law.damper_table = mirrored_table(law.damper_table);
  std::swap(law.lower, law.upper);
  for (std::optional<SmoothStop>* stop : {&law.lower, &law.upper}) {
    if (*stop) (*stop)->at = -(*stop)->at;
  }
  if (law.actuator) law.actuator = scaled(*law.actuator, -1.0);
  return law;
}

ForceLaw shifted(ForceLaw law, double by) {
  law.free += by;
  for (std::optional<SmoothStop>* stop : {&law.lower, &law.upper}) {
    if (*stop) (*stop)->at += by;
  }
  return law;
}

void shift_coordinate(Model& model, int k, int word, int component, double by) {
  Joint& joint = model.joints[static_cast<std::size_t>(k)];
  for (Driver& driver : joint.drivers) {
    if (driver.word == word && driver.component == component) driver.law = shifted(driver.law, by);
  }
  for (JointSpring& spring : joint.springs) {
    if (spring.word == word && spring.component == component) spring.law = shifted(spring.law, by);
  }
  for (Coupling& coupling : model.couplings) {
    for (const CouplingTerm& term : coupling.terms) {
      if (term.joint == k && term.word == word && term.component == component) coupling.offset += term.factor * by;
    }
  }
}

}  // namespace concord::compare::invariance
