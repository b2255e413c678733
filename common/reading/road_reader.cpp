#include "common/reading/road_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "common/reading/driver_reader.h"
#include "common/reading/magnitude.h"
#include "common/reading/spelling.h"
#include "common/reading/toml_document.h"

namespace concord {

namespace {

using Profile = decltype(Road::profile);

std::optional<Profile> read_flat(const TableReader& table) {
  if (!table.has("height")) return FlatRoad{};
  const auto height = table.number("height");
  if (!height) return std::nullopt;
  return FlatRoad{*height};
}

std::optional<Profile> read_half_sine(const TableReader& table) {
  if (!table.require({"start", "length", "height"})) return std::nullopt;
  const auto start = table.number("start");
  const auto length = table.positive_number("length");
  const auto height = table.number("height");
  if (!start || !length || !height) return std::nullopt;
  // Its wave is the same as that of a harmonic law.
  if (!stays_usable(Harmonic{.amplitude = *height, .frequency = std::numbers::pi / *length}, 0.0)) {
    table.complain("height", fmt::format("the road's slope or its change goes beyond {}", kLargestSize));
    return std::nullopt;
  }
  return HalfSineBump{.start = *start, .length = *length, .height = *height};
}

std::optional<Profile> read_table(const TableReader& table) {
  auto points = read_points(table, "x", "height", " m");
  if (!points) return std::nullopt;
  const double first = points->x.front();
  const double last = points->x.back();
  SplineTable spline(std::move(points->x), std::move(points->y));
  if (!stays_usable(spline, 0.0)) {
    table.complain("height", fmt::format("the road's slope or its change goes beyond {}", kLargestSize));
    return std::nullopt;
  }
  return RoadTable{std::move(spline), first, last};
}

struct RoadKind {
  std::string_view name;
  KnownKeys keys;
  std::optional<Profile> (*read)(const TableReader&);
};

const std::array<RoadKind, 3>& road_kinds() {
  static const std::array<RoadKind, 3> kKinds{RoadKind{"flat", {"height"}, read_flat},
                                              RoadKind{"half_sine", {"start", "length", "height"}, read_half_sine},
                                              RoadKind{"table", {"x", "height"}, read_table}};
  return kKinds;
}

/// Keys of a road of that kind; while the kind is not known, those of all.
KnownKeys keys_of(const RoadKind* kind) {
  if (kind == nullptr) return {"name", "profile", "start", "length", "x", "height"};
  KnownKeys keys{"name", "profile"};
  keys.insert(keys.end(), kind->keys.begin(), kind->keys.end());
  return keys;
}

/// The kind that a road names, if there is such a kind.
const RoadKind* named_kind(const toml::table& road) {
  const toml::node* said = road.get("profile");
  const auto name = said == nullptr ? std::nullopt : said->value_exact<std::string>();
  const auto found =
      std::find_if(road_kinds().begin(), road_kinds().end(), [&](const RoadKind& one) { return name == one.name; });
  return found == road_kinds().end() ? nullptr : &*found;
}

/// Complains of the profile, which is missing or not known.
void refuse_profile(const TableReader& table) {
  if (!table.require({"profile"})) return;
  const auto name = table.text("profile");
  if (!name) return;
  std::vector<std::string> names;
  for (const RoadKind& kind : road_kinds()) names.emplace_back(kind.name);
  table.complain("profile", fmt::format("unknown profile '{}': {}", *name, suggestion(*name, names, "profiles")));
}

RoadReading read_road(const toml::table& found, FileReading& reading) {
  const RoadKind* kind = named_kind(found);
  const TableReader table(found, title_with_name(found, "road"), keys_of(kind), reading);
  RoadReading result{table.name(), nullptr};
  if (kind == nullptr) {
    refuse_profile(table);
  } else if (auto profile = kind->read(table)) {
    result.road = std::make_shared<const Road>(Road{result.name, std::move(*profile)});
  }
  return result;
}

}  // namespace

std::vector<RoadReading> read_roads(const TableReader& document) {
  std::vector<RoadReading> roads;
  for (const toml::table* found : document.tables("road")) roads.push_back(read_road(*found, document.reading()));
  return roads;
}

}  // namespace concord
