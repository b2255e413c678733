#pragma once

#include "cartesian/actor.h"

/// Tires: their wrenches, and how far they are inside their regimes.
namespace concord::cartesian {

void exert(const Tire& tire, const ForceInstant& at, Actor& actor);
int n_event_functions(const Tire& tire);
double* write_event_functions(const Tire& tire, const ForceInstant& at, const Actor& actor, double* next);

}  // namespace concord::cartesian
