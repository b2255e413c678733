#pragma once

#include "cartesian/forces/applied_force.h"

/// Tires: their wrenches, and how far they are inside their regimes.
namespace concord::cartesian {

void exert(const Tire& tire, const ForceInstant& at, AppliedForce& applied);
int n_event_functions(const Tire& tire);
double* write_event_functions(const Tire& tire, const ForceInstant& at, const AppliedForce& applied, double* next);
/// How far the force in the regime that is kept departs from that of the tire's own regime, over stiffness and radius.
double departure_of(const Tire& tire, const ForceInstant& at, const AppliedForce& applied);

}  // namespace concord::cartesian
