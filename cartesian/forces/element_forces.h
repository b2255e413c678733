#pragma once

#include "cartesian/forces/applied_force.h"

/// Forces of the elements of a model, by kind: springs and tires, which have regimes, in files of their own; kinds
/// without regimes here.
namespace concord::cartesian {

/// What resists turning in all directions is refused beyond it: its angles jump at half a turn.
inline constexpr double kLargestAngle = 175.0 * EIGEN_PI / 180.0;

/// Writes the wrenches at the ends of an element's applied force, whose markers and motion are those of the instant.
/// Throws SolverError, naming the element, where its law has no direction: a line spring whose force jumps where its
/// ends meet, what resists all turning beyond 175 deg, a turn spring whose axis x points along z, a tire whose
/// axis stands upright on the road.
void exert(const ForceElement& element, const ForceInstant& at, AppliedForce& applied);

/// How many event functions an element has; 0 if it has no regimes.
int n_event_functions(const ForceElement& element);

/// Writes how far an element is inside the regimes of its applied force, and returns what comes after that.
double* write_event_functions(const ForceElement& element, const ForceInstant& at, const AppliedForce& applied,
                              double* next);

/// How far the force in the regime that is kept departs from the element's law (kLargestDeparture).
double departure_of(const ForceElement& element, const ForceInstant& at, const AppliedForce& applied);

}  // namespace concord::cartesian
