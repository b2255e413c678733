#include "common/reading/force_law_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/reading/driver_reader.h"
#include "common/reading/magnitude.h"

namespace concord {

namespace {

/// Keys of which a law must have at least one to exert anything.
const KnownKeys& acting_keys() {
  static const KnownKeys kKeys{"stiffness",    "damping",    "preload",    "spring_table",
                               "damper_table", "lower_stop", "upper_stop", "actuator"};
  return kKeys;
}

std::optional<ForceTable> read_table(const TableReader& law, std::string_view key) {
  const toml::table* found = law.table(key);
  if (found == nullptr) return std::nullopt;
  const TableReader table(*found, fmt::format("{}, {}", law.title(), key), {"x", "force"}, law.reading());
  auto points = read_points(table, "x", "force", "");
  if (!points) return std::nullopt;
  if (!stays_usable(SplineTable(points->x, points->y), 0.0)) {
    table.complain("force", fmt::format("a slope of the table or its change goes beyond {}", kLargestSize));
    return std::nullopt;
  }
  return ForceTable(std::move(points->x), std::move(points->y));
}

std::optional<SmoothStop> read_stop(const TableReader& law, std::string_view key) {
  const toml::table* found = law.table(key);
  if (found == nullptr) return std::nullopt;
  const TableReader table(*found, fmt::format("{}, {}", law.title(), key), {"at", "stiffness", "damping", "width"},
                          law.reading());
  const bool complete = table.require({"at", "stiffness", "width"});
  const auto at = table.number("at");
  const auto stiffness = table.positive_number("stiffness");
  const auto width = table.positive_number("width");
  const auto damping = table.has("damping") ? table.number_not_negative("damping") : 0.0;
  if (!complete || !at || !stiffness || !width || !damping) return std::nullopt;
  return SmoothStop{.at = *at, .stiffness = *stiffness, .damping = *damping, .width = *width};
}

}  // namespace

KnownKeys with_force_law(KnownKeys own) {
  own.insert(own.end(), acting_keys().begin(), acting_keys().end());
  own.push_back("free");
  return own;
}

ForceLaw read_force_law(const TableReader& table) {
  ForceLaw law;
  law.stiffness = table.number("stiffness").value_or(0.0);
  law.damping = table.number_not_negative("damping").value_or(0.0);
  law.free = table.number("free").value_or(0.0);
  law.preload = table.number("preload").value_or(0.0);
  law.spring_table = read_table(table, "spring_table");
  law.damper_table = read_table(table, "damper_table");
  law.lower = read_stop(table, "lower_stop");
  law.upper = read_stop(table, "upper_stop");
  law.actuator = read_law_or_number(table, "actuator");
  if (law.lower && law.upper && law.lower->at >= law.upper->at) {
    table.complain("upper_stop", fmt::format("the upper stop must be above the lower one at {}, found {}",
                                             law.lower->at, law.upper->at));
  }
  const KnownKeys& acting = acting_keys();
  if (std::none_of(acting.begin(), acting.end(), [&](std::string_view key) { return table.has(key); })) {
    table.complain("exerts nothing: give a stiffness, a damping, a preload, a table, a stop or an actuator");
  }
  return law;
}

}  // namespace concord
