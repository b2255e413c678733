#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "common/run_options.h"

namespace concord {

/// Called now and then with the time reached [s].
using Progress = std::function<void(double t)>;

/// One formulation of multibody dynamics, bound to one model. Not thread-safe: one solver per thread.
class Solver {
 public:
  virtual ~Solver() = default;

  [[nodiscard]] virtual std::string_view name() const = 0;

  /// Integrators that integrate() knows, the default for this model first.
  [[nodiscard]] virtual std::vector<std::string> integrators() const = 0;

  /// The start state: kept coordinates, speeds and modal values exactly as the model says, loops closed as far as
  /// round-off lets (at most 1e-13). Throws InputError if the start values contradict each other, naming the joints.
  virtual State assemble() = 0;

  /// Whether assemble() found its state from other values than the model's guesses, because it closed from none of
  /// them.
  [[nodiscard]] virtual bool has_searched_for_its_start() const { return false; }

  /// The closed state near `guess` at guess.t, as far as round-off lets. Modal coordinates and rates are kept, unless
  /// the loops restrict them, as where a flexible body is held at both ends. Nothing if Newton's method finds none on
  /// the branch that the joints mean.
  virtual std::optional<State> close(const State& guess) = 0;

  /// Accelerations, reactions, total wrenches and driver forces in a closed state. The state is taken as it is, not
  /// projected. Throws SolverError if it has not the machine's shape, if its own closure residual exceeds 1e-12, naming
  /// the joint and the residual, and if a joint stands on another branch or turn; SingularPose where the constraints
  /// lose rank against the machine's generic one.
  virtual Evaluation evaluate(const State& state) = 0;

  /// Rank of the constraints and uniqueness of every reaction, total wrench, driver and coupling force in a closed
  /// state. Decided anew at each state; costs at most what twenty evaluations cost.
  virtual RankReport rank(const State& state) = 0;

  /// Columns that span the velocities which the constraints permit in a closed state, drivers at rest: rows are
  /// [v; omega; adot] of body 1, 2, ... (6 + m each), v scaled by the model's length_scale() (v / length [rad/s]).
  /// Orthonormal once each modal row is divided by the solver's size of its mode, so that they are independent in
  /// whatever unit modal coordinates are.
  virtual MatX tangent(const State& state) = 0;

  /// Integrates from the start state, the model's or that of the options. Throws SolverError with time, place and
  /// reason if it cannot reach the tolerance, and SingularPose if the motion reaches or passes a singular pose, between
  /// steps too.
  virtual Trajectory integrate(const RunOptions& options, const Progress& progress) = 0;

  /// Names of the joints that this solver cuts, in the order of the model; empty if it cuts none.
  [[nodiscard]] virtual std::vector<std::string> cut_joints() const { return {}; }
};

}  // namespace concord
