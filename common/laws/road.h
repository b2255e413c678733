#pragma once

#include <array>
#include <string>
#include <variant>

#include "common/laws/time_function.h"

/// Road profiles: the height z = h(x) of the ground in the global frame, the same at every y. A profile is smooth in
/// stretches; where two meet, h is continuous and a derivative may jump: the slope, or inside a table the third.
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

/// A cubic spline through points inside the table, level with its ends outside; a stretch between any two points.
struct RoadTable {
  SplineTable spline;
  double first = 0.0;  // x of the first and the last point
  double last = 0.0;
};

struct Road {
  std::string name;
  std::variant<FlatRoad, HalfSineBump, RoadTable> profile = FlatRoad{};
};

/// Where a stretch begins and ends [m], infinite where it goes on for ever. Stretches are counted from 0, along x.
std::array<double, 2> edges_of(const Road& road, int stretch);

/// The stretch that x lies in; an edge belongs to the stretch after it.
int stretch_at(const Road& road, double x);

/// The height of a stretch; beyond its edges the stretch's own function goes on.
RoadHeight evaluate(const Road& road, int stretch, double x);

}  // namespace concord
