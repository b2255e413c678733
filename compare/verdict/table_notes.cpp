#include "compare/verdict/table_notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <variant>

#include "common/elements/force_element.h"
#include "common/overloaded.h"

namespace concord::compare {

namespace {

/// A cubic spline of the model, and what of it counts.
struct SplineOfModel {
  const SplineTable& points;
  double last;  // beyond it nothing asks for the spline
  double seen;  // of the range of its values: a smaller overshoot is what a cubic is expected to have
};

/// Where a spline leaves the values of two neighbouring points farthest.
struct Overshoot {
  double size = 0.0;
  double x = 0.0;
  double value = 0.0;
  std::size_t after = 0;  // the point before it
};

Overshoot largest_overshoot(const SplineOfModel& spline) {
  constexpr int kLooks = 32;
  const std::vector<double>& x = spline.points.times();
  const std::vector<double>& values = spline.points.values();
  Overshoot largest;
  for (std::size_t k = 0; k + 1 < x.size() && x[k] < spline.last; ++k) {
    const auto [low, high] = std::minmax(values[k], values[k + 1]);
    const double width = std::min(x[k + 1], spline.last) - x[k];
    for (int look = 1; look <= kLooks; ++look) {
      const double at = x[k] + width * look / kLooks;
      const double value = spline.points.evaluate(static_cast<int>(k), at).f;
      const double size = std::max(low - value, value - high);
      if (size > largest.size) largest = {size, at, value, k};
    }
  }
  return largest;
}

/// `what`: "spring_table of joint 'A'".
void note_on(const SplineOfModel& spline, const std::string& what, std::vector<std::string>& notes) {
  const std::vector<double>& x = spline.points.times();
  const std::vector<double>& values = spline.points.values();
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const Overshoot found = largest_overshoot(spline);
  if (!(found.size > spline.seen * (*high - *low))) return;
  notes.push_back(fmt::format(
      "the {} leaves its points: the cubic through them reaches {:.4g} at {:.4g}, between {:.4g} at {:.4g} and {:.4g} "
      "at {:.4g}: give more points where it bends",
      what, found.value, found.x, values[found.after], x[found.after], values[found.after + 1], x[found.after + 1]));
}

void note_on(const std::optional<ForceTable>& table, const std::string& what, std::vector<std::string>& notes) {
  constexpr double kSeen = 0.05;
  if (table) note_on(SplineOfModel{table->points(), table->points().times().back(), kSeen}, what, notes);
}

/// A motion or a road swings beyond its points by a part of its range, as it should.
constexpr double kSeenOfMotion = 0.5;

/// What the last cubic makes of a law after its last point, where the run is longer.
void note_beyond(const SplineTable& table, double until, const std::string& what, std::vector<std::string>& notes) {
  constexpr double kRoundOff = 1e-9;
  const double last = table.times().back();
  if (until <= last + kRoundOff * std::abs(last)) return;
  const int cubic = static_cast<int>(table.times().size()) - 2;
  notes.push_back(fmt::format(
      "the {} ends before the run: after its last point, {:.4g} at {:.4g} s, its last cubic goes on and reaches {:.4g} "
      "at {:.4g} s: give points until then",
      what, table.values().back(), last, table.evaluate(cubic, until).f, until));
}

void note_on(const TimeFunction& law, double until, const std::string& what, std::vector<std::string>& notes) {
  const auto* table = std::get_if<SplineTable>(&law);
  if (table == nullptr) return;
  note_on(SplineOfModel{*table, std::min(until, table->times().back()), kSeenOfMotion}, what, notes);
  note_beyond(*table, until, what, notes);
}

void notes_on_law(const ForceLaw& law, double until, const std::string& owner, std::vector<std::string>& notes) {
  note_on(law.spring_table, "spring_table of " + owner, notes);
  note_on(law.damper_table, "damper_table of " + owner, notes);
  if (law.actuator) note_on(*law.actuator, until, "actuator of " + owner, notes);
}

}  // namespace

std::vector<std::string> notes_on_tables(const Model& model, double until) {
  std::vector<std::string> notes;
  std::set<const Road*> looked_at;
  for (const Joint& joint : model.joints) {
    const std::string owner = fmt::format("joint '{}'", joint.name);
    for (const JointSpring& spring : joint.springs) notes_on_law(spring.law, until, owner, notes);
    for (const Driver& driver : joint.drivers) note_on(driver.law, until, "driver of " + owner, notes);
  }
  for (const ForceElement& element : model.elements) {
    const std::string owner = fmt::format("force element '{}'", element.name);
    each_quantity(element, Overloaded{elements::IgnoreQuantity{},
                                      [&](const elements::LawOverCoordinate<const ForceLaw>& spring) {
                                        notes_on_law(spring.value, until, owner, notes);
                                      },
                                      [&](const elements::FactorOverTime<const TimeFunction>& law) {
                                        note_on(law.value, until, "law of " + owner, notes);
                                      },
                                      [&](const elements::RoadBelow<const std::shared_ptr<const Road>>& below) {
                                        const auto* road = std::get_if<RoadTable>(&below.value->profile);
                                        if (road == nullptr || !looked_at.insert(below.value.get()).second) return;
                                        note_on(SplineOfModel{road->spline, road->last, kSeenOfMotion},
                                                fmt::format("road '{}' of {}", below.value->name, owner), notes);
                                      }});
  }
  return notes;
}

}  // namespace concord::compare
