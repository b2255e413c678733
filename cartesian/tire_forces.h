#pragma once

#include "cartesian/applied_force.h"

/// Tires: their wrenches, and how far they are inside their regimes.
namespace concord::cartesian {

void exert(const Tire& tire, const ForceInstant& at, AppliedForce& applied);
int n_event_functions(const Tire& tire);
double* write_event_functions(const Tire& tire, const ForceInstant& at, const AppliedForce& applied, double* next);

}  // namespace concord::cartesian
