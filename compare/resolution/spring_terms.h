#pragma once

#include "common/model.h"
#include "common/results.h"

/// Springs are differences: what a spring adds up on the way to its force is known no better than to round-off of these
/// terms, however small the force is, as where a machine rests at the free lengths of its springs, or where a motor
/// keeps its speed against a damper or presses against a stop.
namespace concord::compare {

struct SpringTerms {
  double force = 0.0;   // N
  double torque = 0.0;  // N m
};

/// Of a force element in a state; zero for loads. The turns of a turn spring are counted from a known angle [rad].
SpringTerms spring_terms(const ForceElement& element, const State& state, double known_angle);

/// Of the springs, dampers, stops and actuators on a joint's coordinates q and speeds u at time t [s].
SpringTerms spring_terms(const Joint& joint, const VecX& q, const VecX& u, double t);

}  // namespace concord::compare
