#include "compare/nightly/trend.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/error.h"
#include "common/reading/spelling.h"
#include "compare/audit/digits.h"
#include "compare/nightly/regression.h"
#include "compare/nightly/tables.h"
#include "compare/report/text_table.h"

namespace concord::compare::nightly {

namespace {

using Values = std::vector<std::optional<double>>;

struct NamedComponent {
  std::string name;
  std::size_t like_it = 1;  // how many have the part that was asked for in their names
};

NamedComponent name_of_component(const std::vector<Entry>& nights, const std::string& part) {
  std::vector<std::string> known;
  for (const Entry& entry : nights) {
    for (const Component& one : entry.result.components) {
      if (one.name == part) return {part};
      known.push_back(one.name);
    }
  }
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  std::vector<std::string> meant;
  for (const std::string& name : known) {
    if (name.find(part) != std::string::npos) meant.push_back(name);
  }
  if (!meant.empty()) return {meant.front(), meant.size()};
  throw InputError({"--component", 0, 0},
                   fmt::format("no component '{}': {}", part, suggestion(part, known, "components")));
}

const Component* component_named(const Result& result, const std::string& name) {
  const auto found = std::find_if(result.components.begin(), result.components.end(),
                                  [&](const Component& one) { return one.name == name; });
  return found == result.components.end() ? nullptr : &*found;
}

std::optional<double> check_of(const Result& result, const std::string& component,
                               std::optional<double> Component::*check) {
  if (component.empty()) return worst_of(result, check);
  const Component* one = component_named(result, component);
  return one == nullptr ? std::nullopt : one->*check;
}

/// One measure over all nights.
struct Measure {
  std::string name;
  Values values;
};

std::vector<Measure> measures_of(const std::vector<Entry>& nights, const std::string& component) {
  std::vector<Measure> all{{"same state", {}}, {"same run", {}}, {"refined", {}}};
  constexpr std::array kCheckMembers{&Component::same_state, &Component::same_run, &Component::refined};
  for (std::size_t k = 0; k < kCheckMembers.size(); ++k) {
    for (const Entry& entry : nights) all[k].values.push_back(check_of(entry.result, component, kCheckMembers[k]));
  }
  if (!component.empty()) {
    Measure& peak = all.emplace_back(Measure{"peak", {}});
    for (const Entry& entry : nights) peak.values.push_back(check_of(entry.result, component, &Component::peak));
  }
  for (std::size_t who = 0; who < 2; ++who) {
    Measure& cost = all.emplace_back(Measure{who == 0 ? "evaluations of cartesian" : "evaluations of relative", {}});
    for (const Entry& entry : nights) {
      const long count = entry.result.cost[who].evaluations;  // none of what integrates nothing
      cost.values.push_back(count > 0 ? std::optional(static_cast<double>(count)) : std::nullopt);
    }
  }
  Measure& wall = all.emplace_back(Measure{"wall time", {}});
  for (const Entry& entry : nights) wall.values.emplace_back(entry.result.wall_s);
  return all;
}

std::string table_of(const std::vector<Entry>& nights, const std::string& component) {
  std::vector<std::vector<std::string>> lines{{"night", "started", "commit", "compiler", "ending", "same state",
                                               "same run", "refined", "evaluations", "steps", "wall [s]"}};
  for (const Entry& entry : nights) {
    const Result& one = entry.result;
    lines.push_back({fmt::format("{}", entry.night.id), entry.night.started, entry.night.origin.commit,
                     entry.night.origin.compiler, to_string(one.ending),
                     digits_cell(check_of(one, component, &Component::same_state)),
                     digits_cell(check_of(one, component, &Component::same_run)),
                     digits_cell(check_of(one, component, &Component::refined)),
                     pair_cell({one.cost[0].evaluations, one.cost[1].evaluations}),
                     pair_cell({one.cost[0].steps, one.cost[1].steps}), fmt::format("{:.2f}", one.wall_s)});
  }
  return format_table(lines, {true, false, false, false, false, true, true, true, true, true, true});
}

/// Each step between neighbouring nights, with the commit before and after.
std::string steps_of(const std::vector<Entry>& nights, const std::string& component, const Judging& judging) {
  std::string text;
  for (std::size_t k = 1; k < nights.size(); ++k) {
    const Entry& then = nights[k - 1];
    const Entry& now = nights[k];
    for (const Change& change : changes_between(then.result, now.result, judging, "")) {
      if (!component.empty() && !change.component.empty() && change.component != component) continue;
      text += fmt::format("{} in night {}: {}{}{}: {} -> {}; commit {} before, {} after\n", to_string(change.kind),
                          now.night.id, change.component, change.component.empty() ? "" : ", ", change.measure,
                          change.was, change.is, then.night.origin.commit, now.night.origin.commit);
      if (then.result.definition != now.result.definition) {
        text.back() = ';';
        text += " the case is another one: its model, or what the suite says of it, was changed\n";
      }
    }
  }
  return text;
}

/// The results with one component only, so that a step of another one does not hide its own.
std::vector<Entry> with_component(std::vector<Entry> nights, const std::string& component) {
  if (component.empty()) return nights;
  for (Entry& entry : nights) {
    std::erase_if(entry.result.components, [&](const Component& one) { return one.name != component; });
  }
  return nights;
}

}  // namespace

std::string sparkline(const std::vector<std::optional<double>>& values) {
  static constexpr std::array<const char*, 8> kHeights{"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  std::optional<double> least;
  std::optional<double> greatest;
  for (const auto& value : values) {
    if (!value) continue;
    least = std::min(least.value_or(*value), *value);
    greatest = std::max(greatest.value_or(*value), *value);
  }
  std::string line;
  for (const auto& value : values) {
    if (!value) {
      line += ' ';
    } else if (*greatest == *least) {
      line += kHeights[3];
    } else {
      line += kHeights.at(static_cast<std::size_t>(std::lround(7.0 * (*value - *least) / (*greatest - *least))));
    }
  }
  return line;
}

std::string format_trend(const std::string& id, std::vector<Entry> nights, const std::string& component,
                         const Judging& judging) {
  std::reverse(nights.begin(), nights.end());
  const auto [name, like_it] = component.empty() ? NamedComponent{} : name_of_component(nights, component);
  nights = with_component(std::move(nights), name);
  std::string text = fmt::format("{}{}{}: {}\n\n", id, name.empty() ? "" : ", ", name,
                                 plural(static_cast<int>(nights.size()), "night", "nights"));
  if (like_it > 1)
    text.insert(text.size() - 1, fmt::format("the first of {} components like '{}'\n", like_it, component));
  text += table_of(nights, name) + '\n';
  for (const Measure& measure : measures_of(nights, name)) {
    const auto known = [](const std::optional<double>& value) { return value.has_value(); };
    if (std::none_of(measure.values.begin(), measure.values.end(), known)) continue;
    const bool is_digits = measure.name == "same state" || measure.name == "same run" || measure.name == "refined";
    const auto words = [&](const std::optional<double>& value) {
      return !value ? "-" : is_digits ? format_digits(*value) : fmt::format("{:.6g}", *value);
    };
    text += fmt::format("{:<24} {} {} -> {}\n", measure.name, sparkline(measure.values), words(measure.values.front()),
                        words(measure.values.back()));
  }
  const std::string steps = steps_of(nights, name, judging);
  return text + '\n' + (steps.empty() ? "no steps\n" : steps);
}

}  // namespace concord::compare::nightly
