#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>

#include "common/laws/time_function.h"

/// Road profiles: the height z = h(x) of the ground in the global frame, the same at every y. A profile is smooth in
/// stretches; where two meet, h is continuous and its slope may jump.
namespace concord {

/// Height and its first two derivatives over x.
struct RoadHeight {
  double h = 0.0;
  double slope = 0.0;
  double curvature = 0.0;  // h''
};

struct FlatRoad {
  double height = 0.0;
};

/// h = height sin(pi (x - start) / length) for start <= x <= start + length, else zero (S40).
struct HalfSineBump {
  double start = 0.0;   // m
  double length = 1.0;  // m, positive
  double height = 0.0;  // m
};

/// A cubic spline through points inside the table, level with its ends outside.
struct RoadTable {
  SplineTable spline;
  double first = 0.0;  // x of the first and the last point
  double last = 0.0;
};

struct Road {
  std::string name;
  std::variant<FlatRoad, HalfSineBump, RoadTable> profile = FlatRoad{};
};

/// Where three stretches meet, rising [m]: stretch k lies between edge k - 1 and edge k. None: there is one stretch.
std::optional<std::array<double, 2>> edges_of(const Road& road);

/// The stretch that x lies in; an edge belongs to the stretch after it.
int stretch_at(const Road& road, double x);

/// The height of a stretch; beyond its edges the stretch's own function goes on.
RoadHeight evaluate(const Road& road, int stretch, double x);

}  // namespace concord
