#pragma once

#include <string>

#include "cartesian/forces/applied_force.h"
#include "common/line_watch.h"

/// Line springs and turn springs: their wrenches, and how far their stops are inside their regimes.
namespace concord::cartesian {

void exert(const LineSpring& spring, const ForceInstant& at, AppliedForce& applied);
void exert(const TurnSpring& spring, const ForceInstant& at, AppliedForce& applied);

/// The angle of a turn spring at its relative motion [rad], at most half a turn from the known one (C23).
double angle_of_turn_spring(const AppliedForce& applied);

int n_event_functions(const LineSpring& spring);
int n_event_functions(const TurnSpring& spring);

double* write_event_functions(const LineSpring& spring, const ForceInstant& at, const AppliedForce& applied,
                              double* next);
double* write_event_functions(const TurnSpring& spring, const ForceInstant& at, const AppliedForce& applied,
                              double* next);

/// How far the force in the regime that is kept departs from the law.
double departure_of(const LineSpring& spring, const ForceInstant& at, const AppliedForce& applied);
double departure_of(const TurnSpring& spring, const ForceInstant& at, const AppliedForce& applied);

/// The line of a line spring as its applied force lies at time t.
SpringLine line_of(const LineSpring& spring, const std::string& name, const AppliedForce& applied, double t);

}  // namespace concord::cartesian
