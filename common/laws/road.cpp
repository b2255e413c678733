#include "common/laws/road.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/overloaded.h"

namespace concord {

namespace {

RoadHeight level(double height) { return {height, 0.0, 0.0}; }

int n_edges(const HalfSineBump& /*bump*/) { return 2; }
int n_edges(const RoadTable& table) { return static_cast<int>(table.spline.times().size()); }

double edge(const HalfSineBump& bump, int k) { return k == 0 ? bump.start : bump.start + bump.length; }
double edge(const RoadTable& table, int k) {
  if (k == 0) return table.first;
  return k + 1 == n_edges(table) ? table.last : table.spline.times()[static_cast<std::size_t>(k)];
}

RoadHeight evaluate(const HalfSineBump& bump, int stretch, double x) {
  if (stretch != 1) return level(0.0);
  const double k = std::numbers::pi / bump.length;
  const double phase = k * (x - bump.start);
  return {bump.height * std::sin(phase), bump.height * k * std::cos(phase), -bump.height * k * k * std::sin(phase)};
}

RoadHeight evaluate(const RoadTable& table, int stretch, double x) {
  if (stretch == 0) return level(table.spline.evaluate(table.first).f);
  if (stretch == n_edges(table)) return level(table.spline.evaluate(table.last).f);
  const auto at = table.spline.evaluate(stretch - 1, x);
  return {at.f, at.fdot, at.fddot};
}

}  // namespace

std::array<double, 2> edges_of(const Road& road, int stretch) {
  constexpr double kEver = std::numeric_limits<double>::infinity();
  return std::visit(Overloaded{[](const FlatRoad&) {
                                 return std::array{-kEver, kEver};
                               },
                               [&](const auto& profile) {
                                 return std::array{stretch > 0 ? edge(profile, stretch - 1) : -kEver,
                                                   stretch < n_edges(profile) ? edge(profile, stretch) : kEver};
                               }},
                    road.profile);
}

int stretch_at(const Road& road, double x) {
  return std::visit(Overloaded{[](const FlatRoad&) { return 0; },
                               [&](const HalfSineBump& bump) {
                                 return static_cast<int>(x >= edge(bump, 0)) + static_cast<int>(x >= edge(bump, 1));
                               },
                               [&](const RoadTable& table) {
                                 if (x < table.first) return 0;
                                 return x < table.last ? table.spline.piece_at(x) + 1 : n_edges(table);
                               }},
                    road.profile);
}

RoadHeight evaluate(const Road& road, int stretch, double x) {
  return std::visit(Overloaded{[](const FlatRoad& flat) { return level(flat.height); },
                               [&](const auto& profile) { return evaluate(profile, stretch, x); }},
                    road.profile);
}

}  // namespace concord
