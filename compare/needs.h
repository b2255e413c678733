#pragma once

#include <string>

#include "common/model.h"

/// How many digits are enough.
namespace concord::compare {

/// Digits that a quantity must reach on each rung.
struct Needs {
  double same_state = 0.0;
  double same_run = 0.0;
  double refined = 0.0;
  /// Why the model needs fewer than the comparator would ask; empty if it does not.
  std::string because;
};

inline constexpr double kRigidSameState = 12.0;
inline constexpr double kRigidSameRun = 7.0;
inline constexpr double kFlexibleSameState = 10.0;
inline constexpr double kFlexibleSameRun = 6.0;
inline constexpr double kRefined = 8.5;
/// The refined rung is also met if the digits rise by this much when the tolerance falls 100 times.
inline constexpr double kRefinedRise = 1.5;
inline constexpr double kAudit = 9.0;
/// Of the audit's rules on motions, which rest on difference quotients and on how well a run holds its constraints.
inline constexpr double kAuditByDifferences = 7.0;
/// The energy balance of a run may err by this many times its relative tolerance.
inline constexpr double kEnergyPerTolerance = 1e3;

/// What the comparator asks of a model that says nothing.
Needs default_needs(const Model& model);

/// Needs of a component ("F_x" ... "T_z") of a joint: the default, then the model's changes in the order of the file.
Needs needs_of(const Model& model, const std::string& joint, const std::string& component);

/// Throws InputError, each at its place, if a change names no joint or component of the model, or lowers a need
/// without `because`.
void check_needs(const Model& model);

}  // namespace concord::compare
