#pragma once

#include <optional>
#include <string>

#include "compare/invariance/change.h"

/// Other units of length, mass and time.
namespace concord::compare::invariance {

/// Factors by which the numbers of lengths, masses and times grow: {1000, 1e-3, 1} tells a machine in mm, t, s and N.
/// Modal coordinates keep their numbers unless `modal` says how they grow.
struct Units {
  double length = 1.0;
  double mass = 1.0;
  double time = 1.0;
  double modal = 1.0;

  [[nodiscard]] double force() const { return mass * length / (time * time); }
  [[nodiscard]] double torque() const { return force() * length; }
  /// How a coordinate grows, and the force on it.
  [[nodiscard]] double coordinate(bool is_length) const { return is_length ? length : 1.0; }
  [[nodiscard]] double force_on(bool is_length) const { return is_length ? force() : torque(); }
};

/// Why a machine cannot be told in other units: a joint type by functions states lengths that nothing else knows.
/// Nothing if it can.
std::optional<std::string> why_no_other_units(const Model& model);

/// The whole statement in other units. The sum of a coupling keeps its number. Throws std::logic_error where
/// why_no_other_units() says something.
Model told_in_units(Model model, const Units& units);

/// Tells the machine in other units.
Change in_units(const Model& first, const Units& units);

}  // namespace concord::compare::invariance
