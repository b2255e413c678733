#include "compare/audit/law_of_road.h"

#include <cmath>
#include <numbers>

namespace concord::compare {

namespace {

Moving level_at(double height) { return {height, 0.0, 0.0}; }

}  // namespace

LawOfRoad::LawOfRoad(const Road& stated) : stated_(&stated) {
  if (const auto* table = std::get_if<RoadTable>(&stated.profile)) curve_.emplace(table->spline);
}

Moving LawOfRoad::at(double x) const {
  return std::visit([&](const auto& profile) { return evaluate(profile, x); }, stated_->profile);
}

Moving LawOfRoad::evaluate(const FlatRoad& flat, double /*x*/) const { return level_at(flat.height); }

/// The edge where a stretch begins belongs to it.
Moving LawOfRoad::evaluate(const HalfSineBump& bump, double x) const {
  if (x < bump.start || x >= bump.start + bump.length) return level_at(0.0);
  return bump.height * sine(std::numbers::pi / bump.length * (-bump.start + at_unit_rate(x)));
}

Moving LawOfRoad::evaluate(const RoadTable& /*table*/, double x) const {
  if (x < curve_->first()) return level_at(curve_->at({curve_->first(), 0.0, 0.0}).value);
  if (x >= curve_->last()) return level_at(curve_->at({curve_->last(), 0.0, 0.0}).value);
  return curve_->at(at_unit_rate(x));
}

}  // namespace concord::compare
