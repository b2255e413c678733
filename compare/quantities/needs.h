#pragma once

#include <array>
#include <string>

namespace concord {
struct Model;
}  // namespace concord

/// How many digits are enough.
namespace concord::compare {

struct Quantity;

/// The checks at which digits are judged, in their order.
enum class Check { same_state, same_run, refined };
inline constexpr std::array kChecks{Check::same_state, Check::same_run, Check::refined};

/// "same state", "same run", "refined".
const char* name_of(Check check);

/// Digits that a quantity must reach on each check.
struct Needs {
  double same_state = 0.0;
  double same_run = 0.0;
  double refined = 0.0;
  /// Why the model needs fewer than the comparator would ask; empty if it does not.
  std::string because;
  /// Whether the same state needs fewer than that: then its need alone judges.
  bool same_state_lowered = false;
};

inline constexpr double kRigidSameState = 12.0;
inline constexpr double kRigidSameRun = 7.0;
inline constexpr double kFlexibleSameState = 10.0;
inline constexpr double kFlexibleSameRun = 6.0;
inline constexpr double kRefined = 8.5;
/// The refined check is also met if the digits rise by this part of those by which the tolerance was tightened: what an
/// integration leaves falls with the tolerance, a mistake does not.
inline constexpr double kRisePerDigit = 0.75;
/// The energy balance of a run may err by this many times its relative tolerance.
inline constexpr double kEnergyPerTolerance = 1e3;

double need_of(const Needs& needs, Check check);

/// What the comparator asks of a model that says nothing.
Needs default_needs(const Model& model);

/// Needs of a quantity: the default, then the model's changes in the order of the file. A change that names a joint
/// holds for its reactions, total wrenches, driver and coupling forces and for the sums on its bodies, one that names a
/// force element for its wrenches, one that names a body for its accelerations and the sum on it, one without a name
/// for all.
Needs needs_of(const Model& model, const Quantity& quantity);

/// Throws InputError, each at its place, if a change names no joint, force element, body or component of the model, or
/// lowers a need without `because`.
void check_needs(const Model& model);

}  // namespace concord::compare
