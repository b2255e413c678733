#pragma once

#include <vector>

#include "common/model.h"

namespace concord {

/// Times at which some derivative of a law of time jumps: where a smooth step begins and ends, the inner knots of a
/// table. Between them the law is one analytic function. Rising [s].
std::vector<double> break_times(const TimeFunction& law);

/// Those of all laws of a model that lie within a run: of drivers, actuators and loads. Times that lie closer than
/// round-off of the run to each other, to its start or to its end are one. A step of an integrator that passes over one
/// of them has an error that its own estimate need not see. Rising [s].
std::vector<double> break_times(const Model& model, double until);

/// Whether a driver, an actuator or a load of the model follows a law of time other than a constant.
bool has_laws_of_time(const Model& model);

}  // namespace concord
