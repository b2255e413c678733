#pragma once

#include <vector>

#include "common/model.h"
#include "common/results.h"

/// How large a machine is, and how fast it moves: what places, speeds and modes are held against, and their round-off.
namespace concord::compare {

/// The largest of the coordinates of places, or the machine's length [m].
double size_of_places(const State& state, double length);

/// The speed of the fastest body, turns at the end of the machine's length [m/s].
double size_of_speeds(const State& state, double length);

/// The sizes of a machine, and the largest ones of its motion over the states that it has seen.
struct MachineSize {
  /// Before any state: nothing moves, and all places are within the length.
  explicit MachineSize(const Model& model);
  MachineSize(const Model& model, const State& state) : MachineSize(model) { take(state); }
  /// Of all samples of a run, which takes as long as the last of them says.
  MachineSize(const Model& model, const Trajectory& run);

  void take(const State& state);

  /// What speeds are held against [m/s]: of a machine that hardly moves a part of the natural speed.
  [[nodiscard]] double speed_or(double part_of_natural = 1e-6) const;

  double length = 0.0;           // Model::length_scale(), m
  double mass = 0.0;             // of all bodies, kg
  double falling = 0.0;          // speed that gravity gives along half the length, m/s
  double natural = 0.0;          // the same, or the length in the time of the run, m/s
  double place = 0.0;            // size_of_places(), m
  double speed = 0.0;            // size_of_speeds(), m/s
  double turning = 0.0;          // the speed over the length, rad/s
  std::vector<VecX> modal;       // of each body the largest of each modal coordinate,
  std::vector<VecX> modal_rate;  // and of its rate
  std::vector<VecX> shapes;      // how far a unit of each mode moves each body, largest_displacements()
};

}  // namespace concord::compare
