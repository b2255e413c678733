#pragma once

#include <optional>

#include "common/laws/road.h"
#include "compare/audit/law_of_time.h"

namespace concord::compare {

/// A road's profile as the third opinion evaluates it, from its statement in data/format alone. The statement must
/// outlive it.
class LawOfRoad {
 public:
  explicit LawOfRoad(const Road& stated);

  /// Height, slope and curvature over x [m, 1, 1/m].
  [[nodiscard]] Moving at(double x) const;

 private:
  [[nodiscard]] Moving evaluate(const FlatRoad& flat, double x) const;
  [[nodiscard]] Moving evaluate(const HalfSineBump& bump, double x) const;
  [[nodiscard]] Moving evaluate(const RoadTable& table, double x) const;

  const Road* stated_;
  std::optional<Spline> curve_;
};

}  // namespace concord::compare
