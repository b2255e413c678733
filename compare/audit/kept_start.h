#pragma once

#include <string>

#include "common/model.h"
#include "common/results.h"

/// Does a run start where the model says? Of more kept values than the machine has freedoms as many as are free are met
/// exactly, and the others to half a unit of their last digit. What `keep`, `keep_speed`, `a`, `adot` and drivers state
/// is asked of each solver alone: two that drop it alike agree in all else.
namespace concord::compare {

/// The stated number that a start misses most.
struct KeptStart {
  double off = 0.0;   // as a part of its size
  std::string owner;  // "joint hinge", "body blade"
  std::string what;   // "turn_z", "speed of turn_z", "a_2"
  double found = 0.0;
  double stated = 0.0;

  [[nodiscard]] bool holds() const;
  /// "does not start where the model says: joint hinge, turn_z: 0.2 in place of 0.1".
  [[nodiscard]] std::string text() const;
};

/// Sizes are 1 rad or the angle, the machine's length or the displacement; of a speed the largest in the run, over the
/// length for turns; of modal coordinates the largest number of the body, at least what displaces it by a
/// millionth of these.
KeptStart audit_kept_start(const Model& model, const Trajectory& run);

/// The same of a start whose run is not known: speeds beside those of the start.
KeptStart audit_kept_start(const Model& model, const State& start);

/// The same of the coordinates of joints alone.
KeptStart audit_kept_coordinates(const Model& model, const State& start);

}  // namespace concord::compare
