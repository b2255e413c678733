#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/model.h"
#include "common/results.h"

/// Parts that a CAD program exports in the frame of the whole assembly lie far from their own frames. About such a
/// frame the moment of inertia is that of the lever, m d^2, beside which the body's own drowns.
/// Needed by such parts: a door latch in the frame of its car ran for minutes (tests/verification/far_frames_test), and
/// tests/faults/machine_far.toml.
namespace concord::compare {

/// A machine whose bodies are all described in frames that lie in them or beside them, and the way back. A frame is
/// moved to the body's mass centre, axes parallel, where that is farther away than ten times what the body measures:
/// its radius of gyration, and how far its joints and force elements are from its mass centre. All others stay. So does
/// the world, unless the machine stands a thousand of its lengths from the origin, and on no road: then the origin is
/// moved to it.
class NearFrames {
 public:
  /// Throws SolverError if the machine in near frames is not the one that was given, by an account of the audit's own
  /// (compare/audit/same_machine), and InputError for a flexible body whose frame is more than a million times as far
  /// away as it measures.
  explicit NearFrames(Model given);

  [[nodiscard]] const Model& model() const { return model_; }
  /// What was moved; empty if nothing was.
  [[nodiscard]] const std::string& note() const { return note_; }
  /// Motions of the near frames as motions of those that the model has. Throws SolverError if a rule of the audit that
  /// the run keeps in near frames is broken there by the model that was given: needs are lower by the digits of
  /// distance over length, since what a lever amplifies is round-off too, but at least one.
  [[nodiscard]] Trajectory back(Trajectory run) const;
  /// The same of both solvers' runs, as far as there are any.
  [[nodiscard]] std::array<std::optional<Trajectory>, 2> back(std::array<std::optional<Trajectory>, 2> runs) const;

 private:
  [[nodiscard]] Trajectory led_back(Trajectory run) const;

  Model given_;
  Model model_;
  std::vector<Vec3> moved_;  // by body, in its axes; of ground the world's origin [m]
  std::string note_;
};

}  // namespace concord::compare
