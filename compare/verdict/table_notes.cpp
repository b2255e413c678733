#include "compare/verdict/table_notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <variant>

#include "common/laws/force_elements.h"

namespace concord::compare {

namespace {

/// Where a table leaves the forces of two neighbouring points farthest.
struct Overshoot {
  double size = 0.0;
  double x = 0.0;
  double force = 0.0;
  std::size_t after = 0;  // the point before it
};

Overshoot largest_overshoot(const ForceTable& table) {
  constexpr int kLooks = 32;
  const std::vector<double>& x = table.points().times();
  const std::vector<double>& force = table.points().values();
  Overshoot largest;
  for (std::size_t k = 0; k + 1 < x.size(); ++k) {
    const auto [low, high] = std::minmax(force[k], force[k + 1]);
    for (int look = 1; look < kLooks; ++look) {
      const double at = x[k] + (x[k + 1] - x[k]) * look / kLooks;
      const double value = table.evaluate(at);
      const double size = std::max(low - value, value - high);
      if (size > largest.size) largest = {size, at, value, k};
    }
  }
  return largest;
}

void note_on(const std::optional<ForceTable>& table, const char* key, const std::string& owner,
             std::vector<std::string>& notes) {
  constexpr double kSeen = 0.05;  // of the table's range
  if (!table) return;
  const std::vector<double>& x = table->points().times();
  const std::vector<double>& force = table->points().values();
  const auto [low, high] = std::minmax_element(force.begin(), force.end());
  const Overshoot found = largest_overshoot(*table);
  if (!(found.size > kSeen * (*high - *low))) return;
  notes.push_back(fmt::format(
      "the {} of {} leaves its points: the cubic through them reaches {:.4g} at {:.4g}, between {:.4g} at {:.4g} and "
      "{:.4g} at {:.4g}: give more points where it bends",
      key, owner, found.force, found.x, force[found.after], x[found.after], force[found.after + 1],
      x[found.after + 1]));
}

void notes_on_law(const ForceLaw& law, const std::string& owner, std::vector<std::string>& notes) {
  note_on(law.spring_table, "spring_table", owner, notes);
  note_on(law.damper_table, "damper_table", owner, notes);
}

}  // namespace

std::vector<std::string> notes_on_tables(const Model& model) {
  std::vector<std::string> notes;
  for (const Joint& joint : model.joints) {
    for (const JointSpring& spring : joint.springs)
      notes_on_law(spring.law, fmt::format("joint '{}'", joint.name), notes);
  }
  for (const ForceElement& element : model.elements) {
    const std::string owner = fmt::format("force element '{}'", element.name);
    if (const auto* line = std::get_if<LineSpring>(&element.what)) notes_on_law(line->law, owner, notes);
    if (const auto* turn = std::get_if<TurnSpring>(&element.what)) notes_on_law(turn->law, owner, notes);
  }
  return notes;
}

}  // namespace concord::compare
