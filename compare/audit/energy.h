#pragma once

#include <string>

#include "common/model.h"
#include "common/results.h"

/// The energy of a machine, from its mass points and modes.
namespace concord::compare {

/// Kinetic energy plus potential energy of gravity (zero at the origin) plus strain energy of the modes [J].
double mechanical_energy(const Model& model, const State& state);

/// How well a run keeps its energy: largest |E(t) - E(0) - work(t)|, relative to the largest of kinetic energy, range
/// of potential and strain energy, and work; at least a millionth of what the largest force would do along the
/// machine's length, which is what a machine at rest is compared with. The error, which is judged, is what exceeds
/// round-off.
struct EnergyReport {
  double error = 0.0;  // J
  double scale = 0.0;  // J
  double t = 0.0;      // s, where the error is largest
  /// The largest |E(t) - E(0) - work(t)| itself, its time, and what round-off may make of it there [J, s, J].
  double drift = 0.0;
  double t_drift = 0.0;
  double round_off = 0.0;

  [[nodiscard]] double relative() const { return scale > 0.0 ? error / scale : error; }
};

/// "1.2e-13 J at t = 0.3 s, allowed 4.6e-07 J": the drift, and the allowed part of the scale with round-off.
std::string drift_text(const EnergyReport& report, double allowed);

EnergyReport audit_energy(const Model& model, const Trajectory& trajectory);

}  // namespace concord::compare
