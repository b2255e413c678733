#pragma once

#include <string>
#include <vector>

#include "common/solver.h"
#include "compare/verdict/chart.h"

/// Static equilibrium, from a solver's accelerations alone.
namespace concord::compare::analyses {

/// The model at rest: drivers held where their laws are at t = 0, nothing moves at the start.
Model held_at_start(const Model& model);

/// A direction in which a machine at rest meets no stiffness; it is left where the start put it.
struct FreeDirection {
  std::string name;  // "hinge: turn_z 1" or "body coupler: ..."
};

struct Equilibrium {
  State state;
  Evaluation evaluation;
  int iterations = 0;
  /// Size of the last step in the chart's scaled coordinates.
  double last_step = 0.0;
  std::vector<FreeDirection> free;
  /// In so many directions the machine would leave the equilibrium.
  int unstable = 0;
};

/// Finds the equilibrium to which the machine settles from the start, by pseudo-transient continuation: implicit Euler
/// steps along its accelerations, ever longer, then Newton's method on the accelerations. Stiff modes and soft rigid
/// motions do not disturb each other: the modes are eliminated first. Where stiffness is missing (1e-9 of the largest),
/// the step of least norm leaves the direction alone. `model` must be held_at_start() and `solver` made for it. Throws
/// SolverError if nothing resists a force along such a direction, or if no equilibrium is found, saying where and why.
Equilibrium find_equilibrium(const Model& model, Solver& solver);

/// Stiffness seen by motions in which modes follow statically, and the chart's directions without any.
class StiffnessSplit {
 public:
  /// J: derivative of the chart's accelerations with respect to its coordinates; `reference`: accelerations that the
  /// machine's forces cause [1/s2]. There is no stiffness below 1e-9 of the larger one of that and of the largest
  /// stiffness of a motion in which modes follow statically, nor below 1e-14 of J, modes included: that is round-off.
  StiffnessSplit(const Chart& chart, const MatX& J, double reference);

  /// The step of least norm in rigid motions with J step = -f as far as there is stiffness.
  [[nodiscard]] VecX newton_step(const VecX& f) const;
  /// The part of f that no stiffness can meet.
  [[nodiscard]] VecX unmet(const VecX& f) const;
  /// Orthonormal columns without stiffness.
  [[nodiscard]] const MatX& free_directions() const { return free_; }
  /// Largest stiffness per inertia of a motion in which modes follow statically [1/s2].
  [[nodiscard]] double largest() const { return largest_; }
  /// At most so much is no stiffness [1/s2].
  [[nodiscard]] double least() const { return least_; }

 private:
  MatX onto_modes_;  // orthonormal basis of the accelerations that modal coordinates cause
  MatX beyond_;      // and of the rest
  MatX R11_;
  MatX R12_;
  MatX pseudo_inverse_;  // of the condensed stiffness
  MatX unmet_projector_;
  MatX free_;
  double largest_ = 0.0;
  double least_ = 0.0;
};

/// Accelerations in the chart's coordinates where these are delta [1/s2]; nothing if there is no closed state there.
using AccelerationsAt = std::function<std::optional<VecX>(const VecX& delta)>;

/// Derivatives of accelerations with respect to the chart's coordinates, by differences over as much as changes them by
/// ten times `reference`. Throws SingularPose, as found by `solver`, if there are none along one.
MatX stiffness_matrix(const Chart& chart, const Solver& solver, const AccelerationsAt& accelerations, double reference);

/// Accelerations that the machine's forces cause in a state [1/s2]: the largest of gravity and of the sum of forces on
/// a body per mass (a torque counts as its force at the machine's length), over the machine's length.
double reference_acceleration(const Model& model, const Evaluation& evaluation);

}  // namespace concord::compare::analyses
