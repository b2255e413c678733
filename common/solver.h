#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/model.h"
#include "common/results.h"

namespace concord {

struct RunOptions {
  double until = 1.0;   // s
  double rtol = 1e-11;  // relative tolerance of the integrator; absolute ones follow from it and the machine's scales
  int samples = 300;    // equal intervals of the output grid; samples + 1 rows, t = 0 and t = until among them
  std::string integrator;  // empty: the solver's default for this model
  /// A closed state at t = 0 to start from instead of the model's start.
  std::optional<State> start = std::nullopt;
  /// How many evaluations the whole run may take, whatever the integrator makes of them: a run that takes more ends as
  /// EvaluationsSpent.
  std::optional<long> most_evaluations = std::nullopt;
  /// Whether it ends so already where, after a tenth of these, it would take more than twice as many at its pace. A run
  /// whose start is harder than the rest may then end that would have been given enough.
  bool foresees_end = false;
};

/// Called now and then with the time reached [s].
using Progress = std::function<void(double t)>;

/// What of a joint's wrenches a solver finds unique.
struct JointUniqueness {
  /// Per side and component (F_x ... T_z in that side's joint frame): of the reaction, and of the total wrench.
  std::array<std::array<bool, 6>, 2> unique;
  std::array<std::array<bool, 6>, 2> unique_total;
  /// Forces of drivers and couplings by speed of the joint.
  std::array<bool, 6> unique_tau;

  JointUniqueness() {
    for (auto& side : unique) side.fill(true);
    for (auto& side : unique_total) side.fill(true);
    unique_tau.fill(true);
  }
};

/// Rank of the constraints at a state, found by one solver alone.
struct RankReport {
  int constraints = 0;  // rows, drivers included, Euler parameter norms not
  int rank = 0;
  int degrees_of_freedom = 0;  // rigid ones and modal ones
  bool undecided = false;      // a singular value between 1e-12 and 1e-8 of the largest: of the rank, beside `decided`
  double smallest_kept = 0.0;  // relative to the largest singular value
  double largest_dropped = 0.0;
  std::vector<JointUniqueness> joints;
  /// Whether each flag of `joints` stays what it is when the thresholds that decide it are multiplied or divided by the
  /// square root of 1000; false: the flag is undecided. Empty: all stay.
  std::vector<JointUniqueness> decided;
  /// The same two of the force of each coupling. Empty: all unique, and all stay.
  std::vector<bool> unique_coupling;
  std::vector<bool> decided_coupling;
};

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
