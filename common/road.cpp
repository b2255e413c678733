#include "common/road.h"

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

std::vector<double> edges_of(const Road& road) {
  return std::visit(Overloaded{[](const FlatRoad&) { return std::vector<double>{}; },
                               [](const HalfSineBump& bump) {
                                 return std::vector<double>{bump.start, bump.start + bump.length};
                               },
                               [](const RoadTable& table) {
                                 return std::vector<double>{table.first, table.last};
                               }},
                    road.profile);
}

int stretch_at(const Road& road, double x) {
  return std::visit(
      Overloaded{
          [](const FlatRoad&) { return 0; },
          [x](const HalfSineBump& bump) { return (x >= bump.start ? 1 : 0) + (x >= bump.start + bump.length ? 1 : 0); },
          [x](const RoadTable& table) { return (x >= table.first ? 1 : 0) + (x >= table.last ? 1 : 0); }},
      road.profile);
}

RoadHeight evaluate(const Road& road, int stretch, double x) {
  return std::visit(Overloaded{[](const FlatRoad& flat) { return level(flat.height); },
                               [&](const auto& profile) { return evaluate(profile, stretch, x); }},
                    road.profile);
}

}  // namespace concord
