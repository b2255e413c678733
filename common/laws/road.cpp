#include "common/laws/road.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/overloaded.h"

namespace concord {

namespace {

RoadHeight level(double height) { return {height, 0.0, 0.0}; }

RoadHeight evaluate(const HalfSineBump& bump, int stretch, double x) {
  if (stretch != 1) return level(0.0);
  const double k = std::numbers::pi / bump.length;
  const double phase = k * (x - bump.start);
  return {bump.height * std::sin(phase), bump.height * k * std::cos(phase), -bump.height * k * k * std::sin(phase)};
}

RoadHeight evaluate(const RoadTable& table, int stretch, double x) {
  if (stretch != 1) return level(table.spline.evaluate(stretch == 0 ? table.first : table.last).f);
  const auto at = table.spline.evaluate(x);
  return {at.f, at.fdot, at.fddot};
}

}  // namespace

std::optional<std::array<double, 2>> edges_of(const Road& road) {
  using Edges = std::optional<std::array<double, 2>>;
  return std::visit(Overloaded{[](const FlatRoad&) -> Edges { return std::nullopt; },
                               [](const HalfSineBump& bump) -> Edges {
                                 return {{bump.start, bump.start + bump.length}};
                               },
                               [](const RoadTable& table) -> Edges {
                                 return {{table.first, table.last}};
                               }},
                    road.profile);
}

int stretch_at(const Road& road, double x) {
  const auto edges = edges_of(road);
  return edges ? static_cast<int>(x >= (*edges)[0]) + static_cast<int>(x >= (*edges)[1]) : 0;
}

RoadHeight evaluate(const Road& road, int stretch, double x) {
  return std::visit(Overloaded{[](const FlatRoad& flat) { return level(flat.height); },
                               [&](const auto& profile) { return evaluate(profile, stretch, x); }},
                    road.profile);
}

}  // namespace concord
