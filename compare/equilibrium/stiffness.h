#pragma once

#include <functional>
#include <optional>
#include <string>

#include "common/solver.h"
#include "compare/equilibrium/acceleration_scale.h"
#include "compare/states/chart.h"

/// Derivatives of a machine's accelerations, -M^-1 K of its linearization, from a solver's accelerations alone, and how
/// far double precision resolves them.
namespace concord::compare {

/// Accelerations in the chart's coordinates where these are delta [1/s2]; nothing if there is no closed state there.
using AccelerationsAt = std::function<std::optional<VecX>(const VecX& delta)>;

/// J = -M^-1 K: derivatives of accelerations with respect to the chart's coordinates [1/s2], and what each may be wrong
/// by, as measured where they were taken. An eigenvalue of J with a positive real part is an unstable motion.
struct Stiffness {
  MatX J;
  MatX error;
};

/// By differences over as much as changes the accelerations by ten times the reference. A stiff direction allows short
/// steps only, and the round-off of its accelerations covers soft directions that share an axis of the chart with it:
/// those are then differenced again along themselves. Throws SingularPose, as found by `solver`, if there are no closed
/// states along an axis.
Stiffness stiffness_matrix(const Chart& chart, const Solver& solver, const AccelerationsAt& accelerations,
                           const AccelerationScale& scale);

/// The same by one difference for each axis from the accelerations f of the origin: good to about four digits, without
/// errors. Nothing where the stiffness is so large that round-off would be more than that, or where closed states are
/// missing.
std::optional<MatX> rough_stiffness(const Chart& chart, const VecX& f, const AccelerationsAt& accelerations,
                                    double reference);

/// A force with a kink in the chart's origin itself, such as that of a tire that just touches its road, has no
/// derivative there: differences to both sides take the mean of two. The motion that meets it most, in words; empty
/// without one.
std::string kink_at_origin(const Chart& chart, const AccelerationsAt& accelerations, const MatX& J,
                           const AccelerationScale& scale);

/// Stiffness seen by motions in which modes follow statically, and the chart's directions without any.
class StiffnessSplit {
 public:
  /// `scale`: accelerations that the machine's forces and the terms of its springs cause; `f`: accelerations in the
  /// chart's origin, whose turning with the bodies feigns stiffness [1/s2]. There is no stiffness in a direction that
  /// does not exceed what differences resolve in it: the errors measured in it and in softer ones, the round-off of the
  /// entries of J from which it comes, and round-off of `scale`, over a step for what springs add up; `strictness`
  /// times what is otherwise enough, where one asks whether the decision is attached by it.
  StiffnessSplit(const Chart& chart, const Stiffness& stiffness, const AccelerationScale& scale, const VecX& f,
                 double strictness = 1.0);

  /// The step of least norm in rigid motions with J step = -f as far as there is stiffness.
  [[nodiscard]] VecX newton_step(const VecX& f) const;
  /// The part of f that no stiffness can meet.
  [[nodiscard]] VecX unmet(const VecX& f) const;
  /// Orthonormal columns without stiffness.
  [[nodiscard]] const MatX& free_directions() const { return free_; }
  /// Largest stiffness per inertia of a motion in which modes follow statically [1/s2].
  [[nodiscard]] double largest() const { return largest_; }
  /// What is not resolved in the softest direction [1/s2].
  [[nodiscard]] double least() const { return least_; }

 private:
  void split(const MatX& stiffness, const MatX& error, const MatX& round_off);

  double clearly_;
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

}  // namespace concord::compare
