#pragma once

#include "common/results.h"

namespace concord {

/// What a solver may offer beside Solver, so that accelerations can be differentiated without closing each state anew.
class OpenEvaluation {
 public:
  virtual ~OpenEvaluation() = default;

  /// Accelerations of the bodies, and nothing else, where these are at rest and were displaced from a closed state
  /// along velocities that the constraints permit, which leaves them open in second order: to first order in the
  /// displacement they are those of the closed states beside it. Throws SolverError.
  virtual Evaluation evaluate_open(const State& state) = 0;
};

}  // namespace concord
